// SPDX-License-Identifier: Apache-2.0
// Small vectors and matrices used by every formula, on the host and on the device.
// Plain aggregates: trivially copyable, with natural alignment, except Vec4, which is loaded as one word.
#pragma once

#include <cmath>
#include <cstdint>

#include "meltsim/physics/hd.hpp"

namespace meltsim {
inline namespace v0 {
/// Three scalars.
template <class T>
struct Vec3 {
  T x{}, y{}, z{};  ///< components
};

/// Four scalars in one aligned load. Channels store a vector and one more operand in it.
template <class T>
struct alignas(4 * sizeof(T) > 16 ? 16 : 4 * sizeof(T)) Vec4 {
  T x{}, y{}, z{}, w{};  ///< the vector in x, y, z; the operand in w
};

/// Row-major 3x3 matrix.
template <class T>
struct Mat3 {
  T m[3][3]{};  ///< m[row][column]
};

/// Symmetric 3x3 matrix.
template <class T>
struct Sym3 {
  Vec3<T> diagonal{};  ///< xx, yy, zz
  Vec3<T> mixed{};     ///< yz, zx, xy
};

/// Unit quaternion that represents a rotation.
template <class T>
struct Quat {
  T w{1}, x{}, y{}, z{};  ///< w: scalar part; x, y, z: vector part
};

template <class T>
MELTSIM_HD Vec3<T> operator+(Vec3<T> a, Vec3<T> b) {  ///< sum
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T>
MELTSIM_HD Vec3<T> operator-(Vec3<T> a, Vec3<T> b) {  ///< difference
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T>
MELTSIM_HD Vec3<T> operator-(Vec3<T> a) {  ///< negative
  return {-a.x, -a.y, -a.z};
}
template <class T>
MELTSIM_HD Vec3<T> operator*(Vec3<T> a, T s) {  ///< product with a scalar
  return {a.x * s, a.y * s, a.z * s};
}
template <class T>
MELTSIM_HD Vec3<T> operator*(T s, Vec3<T> a) {  ///< product with a scalar
  return a * s;
}
template <class T>
MELTSIM_HD Vec3<T>& operator+=(Vec3<T>& a, Vec3<T> b) {  ///< adds b to a
  a.x += b.x;
  a.y += b.y;
  a.z += b.z;
  return a;
}
template <class T>
MELTSIM_HD T dot(Vec3<T> a, Vec3<T> b) {  ///< scalar product
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
MELTSIM_HD Vec3<T> cross(Vec3<T> a, Vec3<T> b) {  ///< vector product
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T>
MELTSIM_HD T length(Vec3<T> a) {  ///< Euclidean norm
  return std::sqrt(dot(a, a));
}
template <class T>
MELTSIM_HD bool finite(Vec3<T> a) {  ///< whether no component is infinite or NaN
  return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}
template <class T>
MELTSIM_HD Vec3<T> xyz(const Vec4<T>& a) {  ///< the vector without w
  return {a.x, a.y, a.z};
}
template <class T>
MELTSIM_HD Vec4<T> with_w(Vec3<T> a, T w) {  ///< the vector with an operand in w
  return {a.x, a.y, a.z, w};
}
template <class To, class From>
MELTSIM_HD Vec3<To> cast(Vec3<From> a) {  ///< conversion of every component
  return {static_cast<To>(a.x), static_cast<To>(a.y), static_cast<To>(a.z)};
}
/// Identity matrix.
template <class T>
MELTSIM_HD Mat3<T> identity3() {
  Mat3<T> r;
  r.m[0][0] = r.m[1][1] = r.m[2][2] = T(1);
  return r;
}
template <class T>
MELTSIM_HD Vec3<T> operator*(const Mat3<T>& a, Vec3<T> v) {  ///< matrix times vector
  return {a.m[0][0] * v.x + a.m[0][1] * v.y + a.m[0][2] * v.z,
          a.m[1][0] * v.x + a.m[1][1] * v.y + a.m[1][2] * v.z,
          a.m[2][0] * v.x + a.m[2][1] * v.y + a.m[2][2] * v.z};
}
template <class T>
MELTSIM_HD Mat3<T> operator*(const Mat3<T>& a, const Mat3<T>& b) {  ///< matrix product
  Mat3<T> r;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      r.m[i][j] = a.m[i][0] * b.m[0][j] + a.m[i][1] * b.m[1][j] + a.m[i][2] * b.m[2][j];
  return r;
}
template <class T>
MELTSIM_HD Mat3<T> transpose(const Mat3<T>& a) {  ///< transposed matrix
  Mat3<T> r;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) r.m[i][j] = a.m[j][i];
  return r;
}
template <class T>
MELTSIM_HD T determinant(const Mat3<T>& a) {  ///< determinant
  return a.m[0][0] * (a.m[1][1] * a.m[2][2] - a.m[1][2] * a.m[2][1]) -
         a.m[0][1] * (a.m[1][0] * a.m[2][2] - a.m[1][2] * a.m[2][0]) +
         a.m[0][2] * (a.m[1][0] * a.m[2][1] - a.m[1][1] * a.m[2][0]);
}
/// A += s * a b^T
template <class T>
MELTSIM_HD void add_outer(Mat3<T>& A, T s, Vec3<T> a, Vec3<T> b) {
  const T u[3] = {s * a.x, s * a.y, s * a.z};
  const T v[3] = {b.x, b.y, b.z};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) A.m[i][j] += u[i] * v[j];
}

/// A += s * a a^T
template <class T>
MELTSIM_HD void add_square(Sym3<T>& A, T s, Vec3<T> a) {
  const Vec3<T> u = a * s;
  A.diagonal += Vec3<T>{u.x * a.x, u.y * a.y, u.z * a.z};
  A.mixed += Vec3<T>{u.y * a.z, u.z * a.x, u.x * a.y};
}
template <class T>
MELTSIM_HD Mat3<T> to_matrix(const Sym3<T>& A) {  ///< the same matrix, in full
  Mat3<T> r;
  r.m[0][0] = A.diagonal.x;
  r.m[1][1] = A.diagonal.y;
  r.m[2][2] = A.diagonal.z;
  r.m[1][2] = r.m[2][1] = A.mixed.x;
  r.m[0][2] = r.m[2][0] = A.mixed.y;
  r.m[0][1] = r.m[1][0] = A.mixed.z;
  return r;
}

/// A vector rotated by a unit quaternion: v + 2 w (n x v) + 2 n x (n x v), n its vector part.
template <class T>
MELTSIM_HD Vec3<T> rotate(const Quat<T>& q, Vec3<T> v) {
  const Vec3<T> n{q.x, q.y, q.z};
  const Vec3<T> t = cross(n, v) * T(2);
  return v + t * q.w + cross(n, t);
}
/// The inverse of a rotation.
template <class T>
MELTSIM_HD Quat<T> inverse(const Quat<T>& q) {
  return {q.w, -q.x, -q.y, -q.z};
}
/// Rotation matrix of a unit quaternion.
template <class T>
MELTSIM_HD Mat3<T> to_matrix(const Quat<T>& q) {
  const T xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z;
  const T xy = q.x * q.y, xz = q.x * q.z, yz = q.y * q.z;
  const T wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
  Mat3<T> r;
  r.m[0][0] = T(1) - T(2) * (yy + zz);
  r.m[0][1] = T(2) * (xy - wz);
  r.m[0][2] = T(2) * (xz + wy);
  r.m[1][0] = T(2) * (xy + wz);
  r.m[1][1] = T(1) - T(2) * (xx + zz);
  r.m[1][2] = T(2) * (yz - wx);
  r.m[2][0] = T(2) * (xz - wy);
  r.m[2][1] = T(2) * (yz + wx);
  r.m[2][2] = T(1) - T(2) * (xx + yy);
  return r;
}
/// The smaller value; a if neither is smaller.
template <class T>
MELTSIM_HD T minimum(T a, T b) {
  return b < a ? b : a;
}
template <class T>
MELTSIM_HD T maximum(T a, T b) {  ///< the larger value; a if neither is larger
  return a < b ? b : a;
}
MELTSIM_HD float minimum(float a, float b) { return smaller(a, b); }  ///< the smaller value
MELTSIM_HD float maximum(float a, float b) { return larger(a, b); }   ///< the larger value
/// v limited to [lo, hi]; lo if v is NaN, so that a conversion to an integer is always defined.
template <class T>
MELTSIM_HD T clamp(T v, T lo, T hi) {
  return v >= lo ? (hi < v ? hi : v) : lo;
}

}  // namespace v0
}  // namespace meltsim
