// SPDX-License-Identifier: Apache-2.0
// The rotation that best maps one set of weighted points onto another.
//
// Source: Horn (1987), J. Opt. Soc. Am. A 4:629 (Davenport's q-method): the quaternion is the eigenvector of
// the largest eigenvalue of a symmetric 4x4 matrix built from A = sum m x y^T (x current, y rest, both about
// their centres). It maximises sum m x.(R y), so R is a proper rotation for inverted, planar, collinear and
// single-point sets alike, at any scale: A is divided by its norm first and no absolute epsilon appears.
// Eigenvectors by cyclic Jacobi rotations (Golub & Van Loan, sec. 8.5), unconditionally convergent.
// Where the best rotation is not unique (the twist of a chain, a single point), the previous rotation is
// projected on the space of best ones, so the unobservable part stays as it was.
// From one sub-step to the next a region turns by little: Newton's method from the previous rotation (turned_rotation)
// gets there in a step or two. It answers only where its answer is certain to be the best one and
// the only one; elsewhere the eigenvectors do.
#pragma once

#include "meltsim/physics/math.hpp"

namespace meltsim {
inline namespace v0 {
namespace physics {

/// Eigenvalues (diagonal of a, unsorted) and eigenvectors (columns of v) of a symmetric NxN matrix.
template <int N, class T>
MELTSIM_HD void jacobi_eigen(T (&a)[N][N], T (&v)[N][N]) {
  for (int i = 0; i < N; ++i)
    for (int j = 0; j < N; ++j) v[i][j] = i == j ? T(1) : T(0);
  for (int sweep = 0; sweep < 12; ++sweep) {
    T off = 0, diagonal = 0;
    for (int i = 0; i < N; ++i) {
      diagonal += a[i][i] * a[i][i];
      for (int j = i + 1; j < N; ++j) off += a[i][j] * a[i][j];
    }
    // Below the square of rounding relative to the diagonal nothing more can change.
    if (off <= T(sizeof(T) == 8 ? 1e-33 : 1e-16) * diagonal) break;
    for (int p = 0; p < N - 1; ++p)
      for (int q = p + 1; q < N; ++q) {
        const T apq = a[p][q];
        if (apq == T(0)) continue;
        const T theta = (a[q][q] - a[p][p]) / (T(2) * apq);
        const T root = std::sqrt(theta * theta + T(1));
        const T t = std::isfinite(root) ? (theta < T(0) ? T(-1) : T(1)) / (std::fabs(theta) + root) : T(0);
        const T c = T(1) / std::sqrt(t * t + T(1)), s = t * c;
        for (int k = 0; k < N; ++k) {
          const T akp = a[k][p], akq = a[k][q];
          a[k][p] = c * akp - s * akq;
          a[k][q] = s * akp + c * akq;
        }
        for (int k = 0; k < N; ++k) {
          const T apk = a[p][k], aqk = a[q][k];
          a[p][k] = c * apk - s * aqk;
          a[q][k] = s * apk + c * aqk;
        }
        for (int k = 0; k < N; ++k) {
          const T vkp = v[k][p], vkq = v[k][q];
          v[k][p] = c * vkp - s * vkq;
          v[k][q] = s * vkp + c * vkq;
        }
      }
  }
}

/// x with S x = b, by cofactors, if S (symmetric) is positive definite and not near one that is not: its determinant,
/// relative to the cube of its trace, keeps four digits (single precision) or ten. Otherwise false.
template <class T>
MELTSIM_HD bool solve_definite(const Mat3<T>& S, Vec3<T> b, Vec3<T>& x) {
  const T trace = S.m[0][0] + S.m[1][1] + S.m[2][2];
  if (!(trace > T(0))) return false;
  const T inv = T(1) / trace;  // products of small inertias would underflow
  const T xx = S.m[0][0] * inv, yy = S.m[1][1] * inv, zz = S.m[2][2] * inv;
  const T yz = S.m[1][2] * inv, zx = S.m[2][0] * inv, xy = S.m[0][1] * inv;
  const Vec3<T> r0{yy * zz - yz * yz, yz * zx - xy * zz, xy * yz - yy * zx};  // rows of the cofactors
  const T c11 = xx * zz - zx * zx, c12 = xy * zx - xx * yz, c22 = xx * yy - xy * xy;
  const T det = xx * r0.x + xy * r0.y + zx * r0.z;
  if (!(det > T(sizeof(T) == 8 ? 1e-6 : 1e-3)) || !(xx > T(0)) || !(c22 > T(0))) return false;
  const T scale = inv / det;
  x = Vec3<T>{dot(r0, b), r0.y * b.x + c11 * b.y + c12 * b.z, r0.z * b.x + c12 * b.y + c22 * b.z} * scale;
  return true;
}

/// Best rotation for A = sum m x y^T by Newton's method from q, which it replaces; false, and q is anything, where it
/// does not get there. With B = R^T A and S its symmetric part, R turned by omega (about axes at rest) is stationary for
/// sum m x.(R y) where (tr(S) 1 - S) omega = axial part of B - B^T. Where that matrix is positive definite the
/// stationary rotation is a maximum, and SO(3) has no second one: of the critical points S = diag(+-s1, +-s2, +-s3)
/// with the sign of det A only one has all sums of two positive.
template <class T>
MELTSIM_HD bool turned_rotation(const Mat3<T>& A, Quat<T>& q) {
  // A turn of this size leaves an error of its square: below rounding.
  const T small2 = T(sizeof(T) == 8 ? 1e-16 : 1e-7);
  for (int k = 0; k < 4; ++k) {
    const Mat3<T> R = to_matrix(q);
    Mat3<T> B;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        B.m[i][j] = R.m[0][i] * A.m[0][j] + R.m[1][i] * A.m[1][j] + R.m[2][i] * A.m[2][j];
    const T trace = B.m[0][0] + B.m[1][1] + B.m[2][2];
    Mat3<T> M;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) M.m[i][j] = (i == j ? trace : T(0)) - T(0.5) * (B.m[i][j] + B.m[j][i]);
    Vec3<T> turn;
    if (!solve_definite(M, {B.m[2][1] - B.m[1][2], B.m[0][2] - B.m[2][0], B.m[1][0] - B.m[0][1]}, turn))
      return false;
    const Vec3<T> h = turn * T(0.5);
    const Quat<T> r{q.w - q.x * h.x - q.y * h.y - q.z * h.z, q.x + q.w * h.x + q.y * h.z - q.z * h.y,
                    q.y + q.w * h.y + q.z * h.x - q.x * h.z, q.z + q.w * h.z + q.x * h.y - q.y * h.x};
    const T inv = T(1) / std::sqrt(r.w * r.w + r.x * r.x + r.y * r.y + r.z * r.z);
    q = {r.w * inv, r.x * inv, r.y * inv, r.z * inv};
    if (dot(turn, turn) < small2) return true;
  }
  return false;
}

/// Best rotation for A = sum m x y^T (R y ~ x), warm-started by `previous`, which its unobservable part keeps.
template <class T>
MELTSIM_HD Quat<T> best_rotation(const Mat3<T>& A, const Quat<T>& previous) {
  Quat<T> turned = previous;
  if (turned_rotation(A, turned)) return turned;
  T scale = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) scale = maximum(scale, std::fabs(A.m[i][j]));
  if (!(scale > T(0)) || !std::isfinite(scale)) return previous;
  T s[3][3];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) s[i][j] = A.m[j][i] / scale;  // Horn's S: rest (left) to current (right)
  T n[4][4] = {{s[0][0] + s[1][1] + s[2][2], s[1][2] - s[2][1], s[2][0] - s[0][2], s[0][1] - s[1][0]},
               {s[1][2] - s[2][1], s[0][0] - s[1][1] - s[2][2], s[0][1] + s[1][0], s[2][0] + s[0][2]},
               {s[2][0] - s[0][2], s[0][1] + s[1][0], s[1][1] - s[0][0] - s[2][2], s[1][2] + s[2][1]},
               {s[0][1] - s[1][0], s[2][0] + s[0][2], s[1][2] + s[2][1], s[2][2] - s[0][0] - s[1][1]}};
  T v[4][4];
  jacobi_eigen<4>(n, v);
  T top = n[0][0], bottom = n[0][0];
  for (int k = 1; k < 4; ++k) {
    top = maximum(top, n[k][k]);
    bottom = minimum(bottom, n[k][k]);
  }
  // Eigenvalues this close to the largest are the same to rounding: their whole space is best.
  const T gap = T(sizeof(T) == 8 ? 1e-12 : 1e-5) * maximum(top - bottom, T(0));
  const T p[4] = {previous.w, previous.x, previous.y, previous.z};
  T r[4] = {0, 0, 0, 0};
  int best = 0;
  for (int k = 0; k < 4; ++k) {
    if (n[k][k] > n[best][best]) best = k;
    if (n[k][k] < top - gap) continue;
    T along = 0;
    for (int c = 0; c < 4; ++c) along += p[c] * v[c][k];
    for (int c = 0; c < 4; ++c) r[c] += along * v[c][k];
  }
  T norm2 = r[0] * r[0] + r[1] * r[1] + r[2] * r[2] + r[3] * r[3];
  if (norm2 <
      T(1e-6)) {  // the previous rotation says nothing here (turned by 180 degrees): any best one will do
    for (int c = 0; c < 4; ++c) r[c] = v[c][best];
    norm2 = r[0] * r[0] + r[1] * r[1] + r[2] * r[2] + r[3] * r[3];
  }
  const T inv = T(1) / std::sqrt(norm2);
  return {r[0] * inv, r[1] * inv, r[2] * inv, r[3] * inv};
}

/// x with S x = b for a symmetric positive semidefinite S; directions whose eigenvalue is lost in rounding
/// are left out (pseudo-inverse), so a chain does not spin about itself.
template <class T>
MELTSIM_HD Vec3<T> solve_symmetric(const Mat3<T>& S, Vec3<T> b) {
  Vec3<T> direct;
  if (solve_definite(S, b, direct)) return direct;
  const T scale = S.m[0][0] + S.m[1][1] + S.m[2][2];
  if (!(scale > T(0))) return {};
  T a[3][3], v[3][3];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) a[i][j] = S.m[i][j] / scale;  // squares of small inertias would underflow
  b = {b.x / scale, b.y / scale, b.z / scale};
  jacobi_eigen<3>(a, v);
  const T top = maximum(a[0][0], maximum(a[1][1], a[2][2]));
  Vec3<T> x{};
  for (int k = 0; k < 3; ++k) {
    if (!(a[k][k] > T(sizeof(T) == 8 ? 1e-11 : 1e-5) * top)) continue;
    const Vec3<T> e{v[0][k], v[1][k], v[2][k]};
    x += e * (dot(e, b) / a[k][k]);
  }
  return x;
}

}  // namespace physics
}  // namespace v0
}  // namespace meltsim
