// SPDX-License-Identifier: Apache-2.0
// Worlds of unusual size: no particle, fewer than a warp, one more, all in one cell, a domain of 1e6^3 cells,
// more than there is memory for. Densities are compared with sums over all pairs, so that a neighbour that is
// lost or counted twice shows.
#include <sys/resource.h>

#include <cstdio>
#include <random>

#include "meltsim/physics/sph_kernels.hpp"
#include "scenes.hpp"

namespace meltsim_test {
namespace {

constexpr double dx = 0.2;

/// Weightless liquid that does not move: c is given because nothing here has a depth to derive it from.
WorldDesc still(Precision precision, double support = 2.5) {
  WorldDesc d = describe();
  d.precision = precision;
  d.spacing = dx;
  d.support_radius = support * dx;
  d.gravity = {0, 0, 0};
  d.sound_speed = 10;
  return d;
}

/// Lattice sites [low, high).
Shape sites(Vec3d low, Vec3d high) { return Shape::box(low * dx, high * dx); }

void add(World& w, MaterialId water, const Shape& shape) {
  FluidDesc f;
  f.shape = shape;
  f.material = water;
  require(w.add_fluid(f));
}

/// One step so short that nothing moves by an ulp, then density against rho0 sum V W over all pairs. 1e-5 and
/// 1e-12: some 200 additions in the World's precision.
void expect_density_of_all_pairs(World& w, Precision precision, std::size_t particles, double support = 2.5) {
  require(w.step(1e-9));
  const StepResult r = w.synchronize();
  ASSERT_FALSE(r.halted) << r.halt_reason;
  const auto data = *w.particles();
  ASSERT_EQ(data.id.size(), particles);
  const bool in_double = precision == Precision::double_precision;
  const auto kernel = physics::make_kernel<double>(support * dx, dx);
  for (std::size_t i = 0; i < particles; ++i) {
    double phi = 0;
    for (std::size_t j = 0; j < particles; ++j) {
      const double distance = length(data.position[i] - data.position[j]);
      if (distance < kernel.support) phi += dx * dx * dx * physics::kernel_value(kernel, distance);
    }
    ASSERT_NEAR(data.density[i] / (1000 * phi), 1.0, in_double ? 1e-12 : 1e-5) << "particle " << i;
  }
}

class Sizes : public testing::TestWithParam<Precision> {
 protected:
  void SetUp() override { MELTSIM_NEEDS_BACKEND(); }
};
INSTANTIATE_TEST_SUITE_P(Precisions, Sizes,
                         testing::Values(Precision::single_precision, Precision::double_precision),
                         [](const auto& which) {
                           return which.param == Precision::single_precision ? "single" : "double";
                         });

TEST_P(Sizes, NoParticleStepsAndHasNothing) {
  auto w = *World::create(still(GetParam()));
  ASSERT_TRUE(w.add_material({}));  // there could be liquid
  for (int k = 0; k < 3; ++k) require(w.step(0.01));
  EXPECT_FALSE(w.synchronize().halted);
  EXPECT_TRUE(w.particles()->id.empty());
  EXPECT_EQ(w.totals()->mass, 0.0);
  for (const ChannelReport& c : w.plan().channels) EXPECT_EQ(c.bytes, 0u) << c.name;
}

// Around the width of a warp, and of a block of threads.
TEST_P(Sizes, DensityIsThatOfAllPairs) {
  for (const int n : {1, 2, 31, 32, 33, 127, 129}) {
    auto w = *World::create(still(GetParam()));
    const auto water = *w.add_material({});
    const int row = n > 33 ? (n + 2) / 3 : n;  // a line, or three of them
    for (int placed = 0, y = 0; placed < n; placed += row, ++y)
      add(w, water, sites({0, double(y), 0}, {double(std::min(row, n - placed)), y + 1.0, 1}));
    SCOPED_TRACE(n);
    expect_density_of_all_pairs(w, GetParam(), static_cast<std::size_t>(n));
  }
}

// On a GPU a thread takes two of so many particles at a time, where the support is short. A lattice of odd lines in the corner
// of a box, whose images go on with it: all have the density of an endless one but for two layers at the free sides.
// Tolerances as above: here some 33 additions and as many images.
TEST_P(Sizes, DensityOfManyAtAShortSupportIsThatOfAllPairs) {
  const int nx = 61, ny = 59, nz = 57;  // 205,143
  WorldDesc d = still(GetParam(), 2);
  d.domain.bounded = true;
  d.domain.max = Vec3d{nx + 3.0, ny + 3.0, nz + 3.0} * dx;
  auto w = *World::create(d);
  add(w, *w.add_material({}), sites({0, 0, 0}, {double(nx), double(ny), double(nz)}));
  require(w.step(1e-9));
  ASSERT_FALSE(w.synchronize().halted);
  const auto data = *w.particles();
  ASSERT_EQ(data.id.size(), std::size_t{nx * ny * nz});
  const auto kernel = physics::make_kernel<double>(2 * dx, dx);
  double endless = 0;
  for (int k = 0; k < 125; ++k) {
    const double distance = length(Vec3d{k % 5 - 2.0, k / 5 % 5 - 2.0, k / 25 - 2.0} * dx);
    if (distance < kernel.support) endless += dx * dx * dx * physics::kernel_value(kernel, distance);
  }
  std::size_t inside = 0;
  for (std::size_t i = 0; i < data.id.size(); ++i) {
    const Vec3d x = data.position[i] * (1 / dx);
    if (x.x > nx - 2 || x.y > ny - 2 || x.z > nz - 2) continue;
    ++inside;
    ASSERT_NEAR(data.density[i] / (1000 * endless), 1.0,
                GetParam() == Precision::double_precision ? 1e-12 : 1e-5)
        << "particle " << i << " at site " << x.x << ", " << x.y << ", " << x.z;
  }
  EXPECT_EQ(inside, std::size_t{(nx - 2) * (ny - 2) * (nz - 2)});
}

// A body of so few particles, beside liquid and alone.
TEST_P(Sizes, BodiesOfFewParticlesStep) {
  for (const int n : {1, 31, 33})
    for (const bool wet : {false, true}) {
      WorldDesc d = still(GetParam());
      d.heat.time_scale = 1e5;
      auto w = *World::create(d);
      const auto water = *w.add_material({});
      MaterialDesc ice;
      ice.name = "ice";
      ice.melting_point = 0;
      ice.melts_into = water;
      SolidDesc s;
      s.material = *w.add_material(ice);
      s.shape = sites({0, 0, 0}, {double(n), 1, 1});
      s.temperature = -1;
      require(w.add_solid(s));
      if (wet) add(w, water, sites({0, 1, 0}, {1, 2, 1}));
      for (int k = 0; k < 20; ++k) require(w.step(1e-3));
      const StepResult r = w.synchronize();
      EXPECT_FALSE(r.halted) << r.halt_reason;
      EXPECT_EQ(w.particles()->id.size(), static_cast<std::size_t>(n + (wet ? 1 : 0)));
    }
}

// 216 in one cell, about the most a World takes: the centres of 6^3 sites lie in a cell of 5.99 spacings.
TEST_P(Sizes, EverythingInOneCell) {
  const double support = 5.99;
  auto w = World::create(still(GetParam(), support));
  ASSERT_TRUE(w) << w.error().message;
  add(*w, *w->add_material({}), sites({0, 0, 0}, {6, 6, 6}));
  expect_density_of_all_pairs(*w, GetParam(), 216, support);
}

// A particle in its own cell here and there in 1e6^3 cells, every second of them with two more across a
// border of cells. Memory is that of the particles: 80 of them, and nothing of the domain's size.
TEST_P(Sizes, OnePerCellInADomainOfAMillionCellsAnAxis) {
  WorldDesc d = still(GetParam());
  d.domain.bounded = true;
  const double cell = 2.5 * dx, side = 1e6 * cell;
  d.domain.max = {side, side, side};
  auto w = *World::create(d);
  const auto water = *w.add_material({});
  if (GetParam() == Precision::single_precision) {  // which resolves 0.03 m there
    FluidDesc f;
    f.shape = sites({0, 0, 0}, {1, 1, 1});
    f.material = water;
    const auto refused = w.add_fluid(f);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("use double precision"), std::string::npos)
        << refused.error().message;
    return;
  }
  std::mt19937 engine(11);
  std::uniform_int_distribution<std::int64_t> anywhere(1, 1000000 - 3);
  std::size_t particles = 0;
  for (int k = 0; k < 40; ++k) {
    // Two cells are five spacings: of three sites the third is in the next cell.
    const auto at = [&] { return static_cast<double>(anywhere(engine) / 2 * 5); };
    const Vec3d p = k == 0   ? Vec3d{3, 3, 3}  // away from the images of the first cell's walls
                    : k == 1 ? Vec3d{side / dx - 5, side / dx - 5, side / dx - 5}
                             : Vec3d{at() + 5, at() + 5, at() + 5};
    const int length = k % 2 == 0 ? 1 : 3;
    add(w, water, sites(p, p + Vec3d{double(length), 1, 1}));
    particles += static_cast<std::size_t>(length);
  }
  expect_density_of_all_pairs(w, GetParam(), particles);
  EXPECT_LT(w.plan().bytes, std::uint64_t{1} << 20);
}

// --- too little memory ----------------------------------------------------------------------------------

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
constexpr bool sanitized = true;
#else
constexpr bool sanitized = false;
#endif
#elif defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool sanitized = true;
#else
constexpr bool sanitized = false;
#endif

/// Lets this process have only so many bytes more than it has; as it was when it goes out of scope.
class LittleMemory {
 public:
  explicit LittleMemory(std::uint64_t more) {
    getrlimit(RLIMIT_AS, &before_);
    std::uint64_t pages = 0;
    if (std::FILE* f = std::fopen("/proc/self/statm", "r")) {
      if (std::fscanf(f, "%lu", &pages) != 1) pages = 0;
      std::fclose(f);
    }
    rlimit limit = before_;
    limit.rlim_cur = pages * 4096 + more;
    works = pages != 0 && setrlimit(RLIMIT_AS, &limit) == 0;
  }
  ~LittleMemory() { setrlimit(RLIMIT_AS, &before_); }
  LittleMemory(const LittleMemory&) = delete;
  LittleMemory& operator=(const LittleMemory&) = delete;
  bool works = false;

 private:
  rlimit before_{};
};

EmitterDesc nozzle(MaterialId water, std::uint64_t particles) {
  EmitterDesc e;
  e.material = water;
  e.center = {1.2, 2.2, 1.2};
  e.axis = {0, -1, 0};
  e.radius = 0.3;
  e.speed = 1;
  e.max_particles = particles;
  return e;
}

// Capacity is reserved for all that an emitter will emit. Refused with the number of bytes, and the World is
// as it was; on the CPU it also goes on when there is memory, as if it had never been refused.
TEST(Memory, TooLittleIsRefusedWithTheNumberAndChangesNothing) {
  MELTSIM_NEEDS_BACKEND();
  if (sanitized) GTEST_SKIP() << "a sanitizer's own memory does not bear a limit";
  const bool on_cpu = backend() == Backend::cpu;
  Scene s = ice_in_water(describe()), other = ice_in_water(describe());
  for (int k = 0; k < 4; ++k) {
    require(s.world.step(0.002));
    require(other.world.step(0.002));
  }
  // 400,000 particles are 120 MB here. On a device: about the most that add_emitter() takes, of which another World takes three
  // quarters before this one steps.
  EmitterDesc e = nozzle(s.water, on_cpu ? 400000u : 4000000000u);
  Scene hog = ice_in_water(describe());
  for (auto added = s.world.add_emitter(e); !added; added = s.world.add_emitter(e)) {
    ASSERT_FALSE(on_cpu) << added.error().message;
    ASSERT_EQ(added.error().code, ErrorCode::out_of_memory) << added.error().message;
    e.max_particles = e.max_particles / 10 * 9;
    ASSERT_GT(e.max_particles, 1000000u);
  }
  if (!on_cpu) {
    require(hog.world.add_emitter(nozzle(hog.water, e.max_particles / 4 * 3)));
    require(hog.world.step(0.002));
  }
  const auto hash = *s.world.state_hash();
  const double time = s.world.time();
  {
    std::unique_ptr<LittleMemory> little;
    if (on_cpu) little.reset(new LittleMemory(48u << 20));
    if (little && !little->works) GTEST_SKIP() << "no limits on memory here";
    const Status refused = s.world.step(0.002);
    little.reset();
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::out_of_memory);
    const std::string& text = refused.error().message;
    EXPECT_NE(text.find("memory: "), std::string::npos) << text;
    EXPECT_NE(text.find(" GB needed, "), std::string::npos) << text;
    EXPECT_EQ(text.find(" 0.0 GB needed"), std::string::npos) << text;
    EXPECT_NE(text.find(on_cpu ? "not that much" : " GB free"), std::string::npos) << text;
  }
  EXPECT_EQ(*s.world.state_hash(), hash);
  EXPECT_EQ(s.world.time(), time);
  EXPECT_EQ(s.world.steps(), 4u);
  EXPECT_EQ(s.world.particles()->id.size(), other.world.particles()->id.size());
  EXPECT_FALSE(s.world.synchronize().halted);
  if (!on_cpu) return;
  require(other.world.add_emitter(nozzle(other.water, e.max_particles)));
  for (World* w : {&s.world, &other.world}) {
    require(w->step(0.002));
    ASSERT_FALSE(w->synchronize().halted);
  }
  EXPECT_EQ(*s.world.state_hash(), *other.world.state_hash());
}

std::uint64_t bytes_of_channels(World& w) {
  std::uint64_t bytes = 0;
  for (const ChannelReport& c : w.plan().channels) bytes += c.bytes;
  return bytes;
}

// What an upload that failed asked for is no room in reserve: later uploads ask for what they need, as in a World that was
// never refused.
TEST(Memory, ARefusedUploadLeavesNoRoomInReserve) {
  MELTSIM_NEEDS_BACKEND();
  if (sanitized) GTEST_SKIP() << "a sanitizer's own memory does not bear a limit";
  if (backend() == Backend::cuda) GTEST_SKIP() << "a CUDA process maps more than there is";
  const Shape large = sites({20, 0, 0}, {94, 74, 74});  // 405,224: more than 100 MB
  for (const bool stepped : {false, true}) {
    SCOPED_TRACE(stepped ? "taken back by a snapshot" : "taken out again");
    WorldDesc d = still(Precision::single_precision);
    d.reserved_particles = 1000;
    World worlds[2] = {*World::create(d), *World::create(d)};
    const MaterialId water{0, 1};  // the first of any World
    for (World& w : worlds) {
      require(w.add_material({}));
      add(w, water, sites({0, 0, 0}, {3, 3, 3}));
      if (stepped) require(w.step(1e-3));
    }
    World &refused = worlds[0], &other = worlds[1];
    const auto before = *refused.snapshot();
    add(refused, water, large);
    {
      const LittleMemory little(48u << 20);
      if (!little.works) GTEST_SKIP() << "no limits on memory here";
      const Status s = refused.step(1e-3);
      ASSERT_FALSE(s);
      EXPECT_EQ(s.error().code, ErrorCode::out_of_memory) << s.error().message;
    }
    if (stepped) require(refused.restore(before.data(), before.size()));
    else EXPECT_EQ(*refused.remove_liquid(large), 405224u);
    for (World& w : worlds) require(w.step(1e-3));
    EXPECT_EQ(bytes_of_channels(refused), bytes_of_channels(other));
    EXPECT_EQ(*refused.state_hash(), *other.state_hash());
  }
}

struct Emitted {
  const char* name;
  void (*world)(WorldDesc&);
  void (*liquid)(MaterialDesc&);
  bool salt;
};

const Emitted emitted[] = {
    {"single", [](WorldDesc&) {}, [](MaterialDesc&) {}, false},
    {"double", [](WorldDesc& d) { d.precision = Precision::double_precision; }, [](MaterialDesc&) {}, false},
    {"tension", [](WorldDesc& d) { d.tension = true; }, [](MaterialDesc& m) { m.surface_tension = 0.07; },
     false},
    {"viscous", [](WorldDesc&) {}, [](MaterialDesc& m) { m.viscosity = 1e4; }, false},
    {"salt", [](WorldDesc&) {}, [](MaterialDesc&) {}, true},
    {"tree", [](WorldDesc& d) { d.neighbour_search = NeighbourSearch::tree; }, [](MaterialDesc&) {}, false},
    {"wide", [](WorldDesc& d) { d.support_radius = 4 * dx; }, [](MaterialDesc&) {}, false},
};

/// A World of a few particles of warm liquid, ready for nozzle(..., particles); stepped: joined while it runs.
World with_nozzle(const Emitted& c, bool stepped, std::uint64_t particles, bool& taken) {
  WorldDesc d = still(Precision::single_precision);
  d.heat.time_scale = 1;
  d.reserved_particles = 100;
  c.world(d);
  World w = *World::create(d);
  MaterialDesc m;
  m.name = "liquid";
  c.liquid(m);
  const MaterialId liquid = *w.add_material(m);
  EmitterDesc e = nozzle(liquid, particles);
  e.temperature = 40;
  FluidDesc f;
  f.material = liquid;
  f.shape = sites({0, 0, 0}, {3, 3, 3});
  if (c.salt) {
    MaterialDesc salt;
    salt.name = "salt";
    salt.dissolves_in = liquid;
    salt.diffusivity_in = 1e-9;
    e.fractions = f.fractions = {{*w.add_material(salt), 0.1}};
    f.fractions.front().value = 0.2;
  }
  require(w.add_fluid(f));
  if (stepped) require(w.step(1e-4));
  const auto added = w.add_emitter(e);
  taken = bool(added);
  if (!taken) {
    EXPECT_EQ(added.error().code, ErrorCode::out_of_memory) << added.error().message;
    EXPECT_NE(added.error().message.find("max_particles"), std::string::npos) << added.error().message;
  }
  return w;
}

double bytes_with(const Emitted& c, std::uint64_t particles) {
  bool taken = false;
  World w = with_nozzle(c, false, particles, taken);
  EXPECT_TRUE(taken);
  require(w.prepare());
  return double(w.plan().bytes);
}

/// The most particles of a nozzle that are taken, to 1 %.
double most_taken(const Emitted& c, bool stepped) {
  double low = 1e5, high = 3.9e9;
  while (high > 1.01 * low) {
    const double middle = std::sqrt(low * high);
    bool taken = false;
    static_cast<void>(with_nozzle(c, stepped, static_cast<std::uint64_t>(middle), taken));
    (taken ? low : high) = middle;
  }
  return low;
}

// A nozzle brings as many particles as there is memory for: by what they will take, which follows from what the scene computes.
// How much memory there is, is not asked here: of two scenes the one whose particles take twice as much is given half as many.
// Other processes take memory meanwhile, and give it back: so the other scene is asked before and after, until both say the same.
// 10 %: 3 % of what they may differ by, and the search's 1 % twice.
TEST(Memory, NozzlesAreHeldAgainstWhatTheirParticlesWillTake) {
  MELTSIM_NEEDS_BACKEND();
  const auto bytes_of = [](const Emitted& c) {
    return (bytes_with(c, 200000) - bytes_with(c, 100000)) / 1e5;
  };
  const double least = bytes_of(emitted[0]);
  for (const Emitted& c : emitted)
    for (const bool stepped : {false, true}) {
      SCOPED_TRACE(std::string(c.name) + (stepped ? ", stepped" : ", before any step"));
      const double bytes = bytes_of(c);
      double plain = most_taken(emitted[0], false), before = 0, most = 0;
      for (int tries = 0; tries < 20 && std::fabs(plain / before - 1) > 0.03; ++tries) {
        before = plain;
        most = most_taken(c, stepped);
        plain = most_taken(emitted[0], false);
      }
      if (plain > 3.8e9) GTEST_SKIP() << "more memory than particles can be numbered";
      if (&c != emitted) {
        EXPECT_GT(bytes, 1.05 * least);
      }
      EXPECT_NEAR(most * bytes / (plain * least), 1, 0.1)
          << most << " of " << bytes << " bytes, " << plain << " of " << least;
    }
}

}  // namespace
}  // namespace meltsim_test
