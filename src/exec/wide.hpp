// SPDX-License-Identifier: Apache-2.0
// Wider instructions where the CPU has them, without a second build of the library: a function marked
// MELTSIM_WIDE is compiled for AVX2 together with everything it calls (flatten), and is only called where
// wide_instructions() says so. Nothing else in its translation unit is, so no inline function that others
// share can come out with instructions that another machine lacks; what the compiler does not inline is
// called as it is.
//
// Without fused multiply-add, which would be worth little here: results then have the same bits on every CPU,
// wide or not, and what two bodies compute by one formula stays equal to the last bit.
//
// Only bodies that say so (`static constexpr bool wide = true`) are compiled twice, those in which the time of runs and pictures goes,
// because what is flattened takes long to compile.
//
// MELTSIM_ONE_WIDTH leaves the wider code out: the same source twice tells a sanitizer nothing, and takes most of the time.
#pragma once

#if defined(__x86_64__) && defined(__GNUC__) && !defined(MELTSIM_ONE_WIDTH)
#define MELTSIM_WIDE [[gnu::target("avx2,bmi,bmi2,popcnt"), gnu::flatten, gnu::noinline]]
#else
#define MELTSIM_WIDE
#endif

/// Before a loop with independent iterations, which the compiler should vectorise.
#if defined(__GNUC__) && !defined(__clang__)
#define MELTSIM_SIDE_BY_SIDE _Pragma("GCC ivdep")
#else
#define MELTSIM_SIDE_BY_SIDE
#endif

namespace meltsim {
inline namespace v0 {
namespace core {

inline bool wide_instructions() {
#if defined(__x86_64__) && defined(__GNUC__) && !defined(MELTSIM_ONE_WIDTH)
  static const bool has = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi") &&
                          __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("popcnt");
  return has;
#else
  return false;
#endif
}

/// Whether wider instructions are worth a second compilation of a body.
template <class Body, class = void>
inline constexpr bool is_wide = false;
template <class Body>
inline constexpr bool is_wide<Body, decltype(static_cast<void>(Body::wide))> = Body::wide;

}  // namespace core
}  // namespace v0
}  // namespace meltsim
