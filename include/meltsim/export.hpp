// SPDX-License-Identifier: Apache-2.0
// Symbol visibility. The library is built with hidden visibility; only what carries MELTSIM_API is exported.
// It never changes the layout of a type.
#pragma once

#if defined(_WIN32)
#define MELTSIM_API
#else
#define MELTSIM_API __attribute__((visibility("default")))
#endif
