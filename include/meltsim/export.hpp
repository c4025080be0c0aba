// SPDX-License-Identifier: Apache-2.0
// Symbol visibility. The library is built with hidden visibility; only what carries MELTSIM_API is exported, and of a static
// library (MELTSIM_STATIC, which its target passes on to hosts) nothing. It never changes the layout of a type.
#pragma once

#if defined(_WIN32) || defined(MELTSIM_STATIC)
#define MELTSIM_API
#else
#define MELTSIM_API __attribute__((visibility("default")))
#endif
