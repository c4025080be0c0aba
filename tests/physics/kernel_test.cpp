// SPDX-License-Identifier: Apache-2.0
// The kernel against its own integral, finite differences and sums over the lattice. H = 2.5 dx is the
// default, 2 and 3 bracket what is used. Single precision is summed in double: it is the kernel that is
// tested, not the sum.
#include "meltsim/physics/sph_kernels.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "support/random.hpp"

namespace {

using namespace meltsim;
using namespace meltsim::physics;

constexpr double pi = 3.14159265358979323846;

/// visit(offset) for every lattice point within reach.
template <class Visit>
void for_lattice(double support, double dx, const Visit& visit) {
  const int n = static_cast<int>(support / dx) + 1;
  for (int z = -n; z <= n; ++z)
    for (int y = -n; y <= n; ++y)
      for (int x = -n; x <= n; ++x) visit(Vec3<double>{x * dx, y * dx, z * dx});
}

template <class T>
class Kernel : public testing::Test {
 public:
  static constexpr bool is_double = sizeof(T) == 8;
  static double value(const SphKernel<T>& k, double r) {
    return static_cast<double>(kernel_value(k, static_cast<T>(r)));
  }
};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(Kernel, Scalars);

// 2000 midpoints leave 1e-7 of the integral; 1e-4 and 1e-5 are what the library promises.
TYPED_TEST(Kernel, IntegratesToOne) {
  for (const double support : {0.5, 2e-4}) {
    const auto k = uncorrected_kernel<TypeParam>(support);
    const double dr = support / 2000;
    double sum = 0;
    for (int i = 0; i < 2000; ++i) {
      const double r = (i + 0.5) * dr;
      sum += this->value(k, r) * 4 * pi * r * r * dr;
    }
    EXPECT_NEAR(sum, 1.0, this->is_double ? 1e-5 : 1e-4);
  }
}

// Step 1e-5 H: the difference is right to 1e-9 of the largest slope, rounding adds as much.
TEST(Kernel, GradientIsTheFiniteDifference) {
  const double support = 0.5, e = 1e-5 * support;
  const auto k = uncorrected_kernel<double>(support);
  const double largest = kernel_gradient_factor(k, 0.2 * support) * 0.2 * support;
  for (double r = 2 * e; r < support; r += 0.013 * support) {
    const double slope = (kernel_value(k, r + e) - kernel_value(k, r - e)) / (2 * e);
    EXPECT_NEAR(slope, -kernel_gradient_factor(k, r) * r, 1e-8 * largest) << r;
  }
}

// sum V x.grad W = -1 per axis: the gradient of a linear field is exact on the lattice. Rounding of the sum.
TEST(Kernel, GradientOfALinearFieldIsExactOnTheLattice) {
  for (const double ratio : {1.5, 2.5, 4.0}) {
    const auto k = make_kernel<double>(ratio * 0.2, 0.2);
    double sum = 0;
    for_lattice(ratio * 0.2, 0.2,
                [&](Vec3<double> d) { sum += 0.008 * kernel_gradient_factor(k, length(d)) * d.x * d.x; });
    EXPECT_NEAR(sum, 1.0, 1e-12) << ratio;
  }
}

// Opposite points cancel to rounding of the sum: 1e-12 and, with kernel values in float, 1e-6 of its parts.
TYPED_TEST(Kernel, GradientsCancelOnTheLattice) {
  const auto k = make_kernel<TypeParam>(0.5, 0.2);
  Vec3<double> sum{};
  double parts = 0;
  for_lattice(0.5, 0.2, [&](Vec3<double> d) {
    const double f = static_cast<double>(kernel_gradient_factor(k, static_cast<TypeParam>(length(d))));
    sum += d * f;
    parts += length(d) * f;
  });
  EXPECT_LE(length(sum), (this->is_double ? 1e-12 : 1e-6) * parts);
}

// Every sign matters to the heat scheme: 100000 pairs, r up to beyond H.
TYPED_TEST(Kernel, LaplacianIsNeverNegative) {
  using T = TypeParam;
  const auto k = make_kernel<T>(0.5, 0.2);
  test_support::Random random(1);
  for (int i = 0; i < 100000; ++i) {
    const auto r = static_cast<T>(random.uniform(0, 0.6));
    const T l = kernel_laplacian(k, r, r * r);
    ASSERT_GE(l, T(0)) << r;
    ASSERT_TRUE(std::isfinite(l)) << r;
    ASSERT_TRUE(r < T(0.5) || l == T(0)) << r;
  }
}

TYPED_TEST(Kernel, CoincidentParticlesAreFinite) {
  using T = TypeParam;
  const auto k = make_kernel<T>(0.5, 0.2);
  for (const T r : {T(0), std::numeric_limits<T>::denorm_min(), std::numeric_limits<T>::min()}) {
    EXPECT_TRUE(std::isfinite(kernel_value(k, r)));
    EXPECT_TRUE(std::isfinite(kernel_gradient_factor(k, r)));
    EXPECT_GE(kernel_laplacian(k, r, r * r), T(0));
    EXPECT_LE(kernel_laplacian(k, r, r * r), k.laplacian_scale);
  }
  EXPECT_EQ(kernel_laplacian(k, T(0), T(0)), T(0));
  EXPECT_EQ(kernel_gradient_factor(k, T(0)) * T(0), T(0));
}

TYPED_TEST(Kernel, EndsAtTheSupport) {
  using T = TypeParam;
  const auto k = make_kernel<T>(0.5, 0.2);
  for (const T r : {T(0.5), T(0.7), T(100)}) {
    EXPECT_EQ(kernel_value(k, r), T(0));
    EXPECT_EQ(kernel_gradient_factor(k, r), T(0));
    EXPECT_EQ(kernel_laplacian(k, r, r * r), T(0));
  }
}

// L = -2 x.grad W/(r^2 + 0.01 h^2) with h = H/2, written out; rounding only.
TEST(Kernel, LaplacianIsBrookshaws) {
  const double support = 0.5, h = 0.5 * support;
  const auto k = uncorrected_kernel<double>(support);
  for (double r = 0; r < support; r += 0.01) {
    const double expected = 2 * kernel_gradient_factor(k, r) * r * r / (r * r + 0.01 * h * h);
    EXPECT_NEAR(kernel_laplacian(k, r, r * r), expected, 1e-12 * k.laplacian_scale);
  }
}

// What the corrections are for; the sums are theirs up to rounding.
TEST(Kernel, LatticeAtRestReadsRestDensity) {
  for (const double support : {0.4, 0.5, 0.6}) {
    const auto k = make_kernel<double>(support, 0.2);
    double phi = 0;
    for_lattice(support, 0.2, [&](Vec3<double> d) { phi += 0.008 * kernel_value(k, length(d)); });
    EXPECT_NEAR(phi, 1.0, 1e-12);
  }
}

TEST(Kernel, LaplacianOfSquareIsTwo) {
  for (const double support : {0.4, 0.5, 0.6}) {
    const auto k = make_kernel<double>(support, 0.2);
    const double x = 1.7;  // anywhere: the linear part cancels
    double of_square = 0, of_product = 0;
    for_lattice(support, 0.2, [&](Vec3<double> d) {
      const double vl = 0.008 * kernel_laplacian(k, length(d), dot(d, d));
      of_square += vl * ((x + d.x) * (x + d.x) - x * x);
      of_product += vl * (x + d.x) * d.y;
    });
    EXPECT_NEAR(of_square, 2.0, 1e-11);
    EXPECT_NEAR(of_product, 0.0, 1e-11);
  }
}

// Outside 4 % (the header's word, at the default support) a correction would hide a wrong constant.
TEST(Kernel, CorrectionsAreSmall) {
  EXPECT_NEAR(lattice_sum(0.5, 0.2), 1.0, 0.04);
  EXPECT_NEAR(lattice_laplacian_gain(0.5, 0.2), 1.0, 0.04);
}

// A plane halfway between two layers halves the sum: the half-space and its mirror image and nothing else.
TEST(Kernel, HalfSpaceIsWhatALayerMisses) {
  const auto k = make_kernel<double>(0.5, 0.2);
  double own = 0, sum = 0;
  for_lattice(0.5, 0.2, [&](Vec3<double> d) {
    if (d.x > -0.1) own += 0.008 * kernel_value(k, length(d));
    sum += 0.008 * kernel_laplacian(k, length(d), dot(d, d));
  });
  EXPECT_NEAR(own + lattice_half_space(0.5, 0.2), 1.0, 1e-12);
  EXPECT_NEAR(lattice_laplacian_sum(0.5, 0.2) / sum, 1.0, 1e-12);
}

}  // namespace
