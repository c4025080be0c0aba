// SPDX-License-Identifier: Apache-2.0
// Bodies that the host moves: where they are, what liquid and other bodies feel of them, what is refused.
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "scenes.hpp"

namespace meltsim_test {
namespace {

constexpr double pi = 3.14159265358979323846;

WorldDesc steered_desc(Vec3d size, Precision precision = Precision::double_precision) {
  WorldDesc d = describe();
  d.precision = precision;
  d.spacing = 0.1;
  d.sound_speed = 40;  // ten times the largest speed of any scene here, 2 m/s of fall and 1 m/s of the host's
  d.heat.model = HeatModel::none;
  d.domain.bounded = true;
  d.domain.max = size;
  d.domain.no_slip = false;
  return d;
}

MaterialDesc stone() {
  MaterialDesc m;
  m.name = "stone";
  m.density = 2000;
  return m;
}

World make(const WorldDesc& d) {
  auto w = World::create(d);
  EXPECT_TRUE(w) << w.error().message;
  return std::move(*w);
}

BodyId kinematic(World& w, MaterialId material, const Shape& shape, Vec3d velocity = {}, Vec3d spin = {}) {
  SolidDesc s;
  s.material = material;
  s.shape = shape;
  s.motion = Motion::kinematic;
  s.velocity = velocity;
  s.angular_velocity = spin;
  auto id = w.add_solid(s);
  EXPECT_TRUE(id) << id.error().message;
  return *id;
}

double distance(Vec3d a, Vec3d b) { return length(a - b); }
BodyMotion moves_at(Vec3d velocity, Vec3d spin = {}) {
  BodyMotion m;
  m.velocity = velocity;
  m.angular_velocity = spin;
  return m;
}
BodyMotion goes_to(Vec3d position) {
  BodyMotion m;
  m.position = position;
  return m;
}
/// A turn about z [rad].
Quat<double> turned(double angle) { return {std::cos(angle / 2), 0, 0, std::sin(angle / 2)}; }
Vec3d turn(double angle, Vec3d r) {
  return {std::cos(angle) * r.x - std::sin(angle) * r.y, std::sin(angle) * r.x + std::cos(angle) * r.y, r.z};
}

// A circle of radius r at omega for t ends at the angle omega t, to the last bits of a position of 1 m whatever the
// sub-steps were: 1e-12 in double; 2e-7, two units in the last place, in single precision.
TEST(Steering, FollowsItsMotionExactlyWhateverTheSteps) {
  MELTSIM_NEEDS_BACKEND();
  for (const Precision precision : {Precision::double_precision, Precision::single_precision}) {
    const double eps = precision == Precision::double_precision ? 1e-12 : 2e-7;
    World w = make(steered_desc({2, 2, 2}, precision));
    const MaterialId m = *w.add_material(stone());
    const BodyId body = kinematic(w, m, Shape::box({0.8, 0.9, 0.9}, {1.3, 1.1, 1.1}), {}, {0, 0, 2});
    const ParticleData before = *w.particles();
    const Vec3d center{1.05, 1, 1};
    for (const double dt : {0.3, 0.01, 0.2, 0.29}) require(w.step(dt));
    const double angle = 2 * w.time();
    const ParticleData p = *w.particles();
    ASSERT_EQ(p.id.size(), 20u);
    for (std::size_t i = 0; i < p.id.size(); ++i) {
      const Vec3d arm = turn(angle, before.position[i] - center);
      EXPECT_LT(distance(p.position[i], center + arm), eps);
      EXPECT_LT(distance(p.velocity[i], Vec3d{-2 * arm.y, 2 * arm.x, 0}), 2 * eps);
    }
    // To a pose and there it stays; on the way it moves at (pose - pose before)/dt.
    BodyMotion to = goes_to({1.2, 0.8, 1});
    to.orientation = turned(angle + 0.5);
    require(w.set_motion(body, to));
    require(w.step(0.5));
    const auto check_there = [&] {
      const ParticleData q = *w.particles();
      for (std::size_t i = 0; i < q.id.size(); ++i) {
        const Vec3d arm = turn(angle + 0.5, before.position[i] - center);
        EXPECT_LT(distance(q.position[i], Vec3d{1.2, 0.8, 1} + arm), eps);
        EXPECT_LT(length(q.velocity[i]), eps);
      }
    };
    check_there();
    require(w.step(0.5));
    check_there();
    const BodyMotion now = *w.motion(body);
    EXPECT_LT(distance(*now.position, {1.2, 0.8, 1}), 1e-12);
    EXPECT_EQ(length(now.velocity), 0.0);
    // On the way it has the velocity of the way: liquid and bodies see that.
    static_cast<void>(w.synchronize());
    require(w.set_motion(body, goes_to({1.1, 0.8, 1.2})));
    require(w.step(0.5));
    EXPECT_NEAR(w.synchronize().max_speed, std::sqrt(0.1 * 0.1 + 0.2 * 0.2) / 0.5, eps);
    require(w.set_motion(body, goes_to({1.2, 0.8, 1})));
    require(w.step(0.5));
    // A velocity alone: it goes on from there, for good.
    require(w.set_motion(body, moves_at({-0.5, 0, 0})));
    for (int k = 0; k < 3; ++k) require(w.step(0.1));
    EXPECT_LT(distance(*w.motion(body)->position, {1.05, 0.8, 1}), 1e-12);
    EXPECT_LT(distance(w.motion(body)->velocity, {-0.5, 0, 0}), 1e-12);
  }
}

// The lower half of a body that turns about a pivot of its own moves as the pivot says.
TEST(Steering, TurnsAboutItsPivot) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(steered_desc({2, 2, 2}));
  SolidDesc s;
  s.material = *w.add_material(stone());
  s.shape = Shape::box({1, 1, 0.9}, {1.5, 1.2, 1.1});
  s.motion = Motion::kinematic;
  s.pivot = Vec3d{1, 1, 1};
  const BodyId body = *w.add_solid(s);
  const ParticleData before = *w.particles();
  BodyMotion m;
  m.orientation = turned(pi / 2);
  require(w.set_motion(body, m));
  require(w.step(0.25));
  const ParticleData p = *w.particles();
  for (std::size_t i = 0; i < p.id.size(); ++i)
    EXPECT_LT(distance(p.position[i], Vec3d{1, 1, 1} + turn(pi / 2, before.position[i] - Vec3d{1, 1, 1})),
              1e-12);
}

/// The last force of the liquid on the body of the only probe.
double last_force_y(World& w) {
  auto taken = *w.take_samples();
  return taken.at(0).values.at(taken[0].values.size() - 2);
}

// A piston that fills a shaft without friction lifts a column: its work is the energy that the column has gained. It sets
// off and stops over 0.2 s, four times the way of sound through the column and back, so that next to nothing goes into waves.
TEST(Steering, APistonsWorkIsTheEnergyGained) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(steered_desc({0.6, 1.8, 0.6}));
  const MaterialId m = *w.add_material(stone()), water = *w.add_material({});
  const BodyId piston = kinematic(w, m, Shape::box({0, 0, 0}, {0.6, 0.2, 0.6}));
  FluidDesc f;
  f.material = water;
  f.shape = Shape::box({0, 0.2, 0}, {0.6, 0.8, 0.6});
  require(w.add_fluid(f));
  ProbeDesc probe;
  probe.kind = ProbeKind::force;
  probe.body = piston;
  probe.fields = {"force"};
  require(w.add_probe(probe));
  for (int k = 0; k < 400; ++k)
    require(w.step(2.5e-3));  // it settles: 1 s, twenty times the way of sound and back
  static_cast<void>(w.take_samples());
  const double piston_mass = 72 * 2.0, v = 0.2, dt = 2.5e-3;
  const auto energy = [&] {
    const Totals t = *w.totals();
    const Vec3d x = *w.motion(piston)->position;
    const double speed = length(w.motion(piston)->velocity);
    return t.kinetic + t.potential - piston_mass * (9.81 * x.y + 0.5 * speed * speed);
  };
  const double before = energy();
  double work = 0;
  for (int k = 0; k < 880; ++k) {  // 0.4 m: as far as at full speed for 2 s
    const double now = v * std::min({1.0, (k + 0.5) / 80, (879.5 - k) / 80});
    require(w.set_motion(piston, moves_at({0, now, 0})));
    require(w.step(dt));
    work += -last_force_y(w) * now * dt;
  }
  require(w.set_motion(piston, moves_at({})));
  for (int k = 0; k < 200; ++k) require(w.step(dt));
  EXPECT_FALSE(w.synchronize().halted);
  const double gained = energy() - before, mgh = 216 * 1.0 * 9.81 * 0.4;
  EXPECT_NEAR(gained, mgh, 0.01 * mgh);
  EXPECT_NEAR(work, gained, 0.01 * mgh);
  const ParticleData p = *w.particles();
  for (const Vec3d& x : p.position) EXPECT_GT(x.y, 0.4);  // nobody below the piston, which is at 0.4 .. 0.6
}

// A plate across a channel sweeps it at 1 m/s: nothing is left behind it.
TEST(Steering, APlateLeavesNothingBehind) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(steered_desc({2, 1.4, 0.5}));
  const MaterialId m = *w.add_material(stone()), water = *w.add_material({});
  const BodyId plate = kinematic(w, m, Shape::box({0.2, 0, 0}, {0.4, 1.4, 0.5}));
  FluidDesc f;
  f.material = water;
  f.shape = Shape::box({0.4, 0, 0}, {2, 0.3, 0.5});
  require(w.add_fluid(f));
  for (int k = 0; k < 48; ++k) {  // 0.8 m at 60 frames a second, as a game's host sets them
    require(w.set_motion(plate, goes_to({0.3 + (k + 1) / 60.0, 0.7, 0.25})));
    require(w.step(1.0 / 60));
  }
  EXPECT_FALSE(w.synchronize().halted);
  EXPECT_NEAR(w.motion(plate)->position->x, 1.1, 1e-12);
  const ParticleData p = *w.particles();
  std::size_t liquid = 0;
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    if (!is_fluid(p.tag[i])) continue;
    ++liquid;
    EXPECT_GT(p.position[i].x, 1.1) << p.id[i];
  }
  EXPECT_EQ(liquid, 16u * 3 * 5);
}

// A cup that is half full: turned by 20 degrees it spills nothing, by 180 it is empty; walls two spacings thick leak nothing.
TEST(Steering, ACupPoursAndDoesNotLeak) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(steered_desc({2.4, 2.4, 1.2}));
  const MaterialId m = *w.add_material(stone()), water = *w.add_material({});
  const Vec3d center{1.2, 1.5, 0.6};
  SolidDesc s;
  s.material = m;
  s.shape =
      Shape::subtract(Shape::box({0.7, 1.1, 0.2}, {1.7, 1.9, 1}), Shape::box({0.9, 1.3, 0.4}, {1.5, 2, 0.8}));
  s.motion = Motion::kinematic;
  s.pivot = center;
  const BodyId cup = *w.add_solid(s);
  FluidDesc f;
  f.material = water;
  f.shape = Shape::box({0.9, 1.3, 0.4}, {1.5, 1.6, 0.8});
  require(w.add_fluid(f));
  const auto inside = [&](double angle) {
    const ParticleData p = *w.particles();
    int n = 0;
    for (std::size_t i = 0; i < p.id.size(); ++i) {
      if (!is_fluid(p.tag[i])) continue;
      const Vec3d r = turn(-angle, p.position[i] - center);
      n += std::fabs(r.x) < 0.3 && std::fabs(r.z) < 0.2 && r.y > -0.2 && r.y < 0.4 ? 1 : 0;
    }
    return n;
  };
  const auto turn_to = [&](double angle, int frames) {
    const Quat<double> q = w.motion(cup)->orientation.value();
    const double from = 2 * std::atan2(q.z, q.w);
    for (int k = 0; k < frames; ++k) {
      BodyMotion to;
      to.orientation = turned(from + (angle - from) * (k + 1) / frames);
      require(w.set_motion(cup, to));
      require(w.step(1.0 / 60));
    }
  };
  for (int k = 0; k < 15; ++k) require(w.step(1.0 / 60));
  EXPECT_EQ(inside(0), 72);
  turn_to(pi / 9, 30);
  for (int k = 0; k < 15; ++k) require(w.step(1.0 / 60));
  EXPECT_EQ(inside(pi / 9), 72);
  turn_to(pi, 60);
  for (int k = 0; k < 30; ++k) require(w.step(1.0 / 60));  // it falls 0.3 m in a quarter of a second
  EXPECT_FALSE(w.synchronize().halted);
  EXPECT_EQ(inside(pi), 0);
}

// A plate that sets off at once drags a block along by friction: mu g t until it is as fast.
TEST(Steering, FrictionCarriesABody) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(steered_desc({3, 1, 1}));
  MaterialDesc rough = stone();
  rough.friction = 0.4;
  const MaterialId m = *w.add_material(rough);
  const BodyId plate = kinematic(w, m, Shape::box({0.2, 0.1, 0.2}, {1.6, 0.3, 0.8}));
  SolidDesc s;
  s.material = m;
  s.shape = Shape::box({0.4, 0.3, 0.4}, {0.8, 0.6, 0.7});
  const BodyId block = *w.add_solid(s);
  const auto velocity = [&] {
    const auto pieces = *w.pieces();
    for (const PieceInfo& p : pieces)
      if (p.body == block) return p.velocity.x;
    return -1.0;
  };
  for (int k = 0; k < 100; ++k) require(w.step(2.5e-3));
  EXPECT_NEAR(velocity(), 0, 1e-3);
  const double v = 0.6, g = 9.81, t = 0.1;  // as fast after v/(mu g) = 0.153 s
  require(w.set_motion(plate, moves_at({v, 0, 0})));
  for (int k = 0; k < 40; ++k) require(w.step(2.5e-3));
  EXPECT_NEAR(velocity(), 0.4 * g * t, 0.05 * 0.4 * g * t);  // contact is a spring: it rocks by some per cent
  for (int k = 0; k < 160; ++k) require(w.step(2.5e-3));
  EXPECT_NEAR(velocity(), v, 0.02 * v);
  EXPECT_NEAR(w.motion(plate)->position->x, 0.9 + 0.5 * v, 1e-12);  // whatever lies on it
}

/// A paddle that turns in a tank.
struct Paddle {
  World world;
  BodyId paddle;
};
Paddle paddle_in_water() {
  World w = make(steered_desc({1.2, 1.2, 1.2}));
  const MaterialId m = *w.add_material(stone()), water = *w.add_material({});
  const BodyId b = kinematic(w, m, Shape::box({0.3, 0.2, 0.5}, {0.9, 0.6, 0.7}), {}, {0, 1, 0});
  FluidDesc f;
  f.material = water;
  f.shape = Shape::box({0, 0, 0}, {1.2, 0.7, 1.2});
  require(w.add_fluid(f));
  return {std::move(w), b};
}

TEST(Steering, ASnapshotInMidMotionGoesOnWithTheSameBits) {
  MELTSIM_NEEDS_BACKEND();
  Paddle a = paddle_in_water(), b = paddle_in_water();
  for (int k = 0; k < 3; ++k) require(a.world.step(0.01));
  BodyMotion m = goes_to({0.62, 0.4, 0.6});
  m.velocity = {-0.3, 0, 0};
  require(a.world.set_motion(a.paddle, m));
  for (int k = 0; k < 2; ++k) require(a.world.step(0.01));
  const std::vector<std::uint8_t> bytes = *a.world.snapshot();
  require(b.world.restore(bytes.data(), bytes.size()));
  EXPECT_EQ(*a.world.state_hash(), *b.world.state_hash());
  for (int k = 0; k < 3; ++k) {
    require(a.world.step(0.01));
    require(b.world.step(0.01));
  }
  EXPECT_EQ(*a.world.state_hash(), *b.world.state_hash());
  EXPECT_EQ(a.world.motion(a.paddle)->position->x, b.world.motion(b.paddle)->position->x);
  // The motion is part of the state: another one is another state, though nothing has moved yet.
  const std::uint64_t same = *b.world.state_hash();
  require(b.world.set_motion(b.paddle, moves_at({})));
  EXPECT_EQ(*b.world.state_hash(), same);  // set, but no step has begun
}

// Motions travel beside the recorded sub-step: with a new one in every step, no more is recorded than in a few.
TEST(Steering, NoMotionCostsAGraph) {
  MELTSIM_NEEDS_BACKEND();
  Paddle a = paddle_in_water();
  const auto stir = [&](int steps) {
    for (int k = 0; k < steps; ++k) {
      require(a.world.set_motion(a.paddle, moves_at({}, {0, 0.1 * (k % 5), 0})));
      require(a.world.step(0.01));
    }
  };
  stir(6);
  const std::uint64_t graphs = a.world.plan().graphs;
  stir(30);
  EXPECT_EQ(a.world.plan().graphs, graphs);
}

// A path of three points: 0.2 m along x in 2 s while it turns by a right angle about z, then back a half in 1 s, and rest; numbers that a
// double has to 1e-12.
std::vector<PosePoint> there_and_back(double begin) {
  const double right = 1.5707963267948966;
  return {{begin, {}, 0}, {begin + 2, {0.2, 0, 0}, right}, {begin + 3, {0.1, 0, 0}, right}};
}
SolidDesc on_path(MaterialId material, std::vector<PosePoint> path) {
  SolidDesc s;
  s.material = material;
  s.shape = Shape::box({0.8, 0.8, 0.8}, {1.2, 1.2, 1.2});
  s.motion = Motion::kinematic;
  s.path = std::move(path);
  return s;
}

// However long the steps are: their sub-steps begin and end at its points.
TEST(Steering, ABodyFollowsItsPathExactlyWhateverTheSteps) {
  MELTSIM_NEEDS_BACKEND();
  for (const double dt : {4.0, 0.7, 0.1}) {
    World w = make(steered_desc({2, 2, 2}));
    const BodyId block = *w.add_solid(on_path(*w.add_material(stone()), there_and_back(0.5)));
    const BodyMotion built = *w.motion(block);
    std::vector<Vec3d> rest;
    require(w.prepare());
    const ParticleData start = *w.particles();
    for (const Vec3d& x : start.position) rest.push_back(x - *built.position);
    while (w.time() < 4) {
      require(w.step(dt));
      const double t = std::min(std::max(0.0, w.time() - 0.5), 3.0);
      const double x = t < 2 ? 0.1 * t : 0.2 - 0.1 * (t - 2),
                   angle = 1.5707963267948966 * std::min(t / 2, 1.0);
      const BodyMotion now = *w.motion(block);
      EXPECT_LT(distance(*now.position, *built.position + Vec3d{x, 0, 0}), 1e-12) << w.time();
      const auto p = *w.particles();
      for (std::size_t i = 0; i < p.id.size(); ++i)
        ASSERT_LT(distance(p.position[i], *built.position + Vec3d{x, 0, 0} + turn(angle, rest[i])), 1e-12)
            << w.time() << " " << i;
    }
    EXPECT_EQ(length(w.motion(block)->velocity), 0);
  }
}

// Liquid sees the velocity of the part of the path that the body is on, and its end.
TEST(Steering, ASnapshotOnAPathGoesOnWithTheSameBits) {
  MELTSIM_NEEDS_BACKEND();
  const auto begin = [] {
    WorldDesc d = steered_desc({1, 1, 1});
    d.spacing = 0.1;
    World w = make(d);
    MaterialDesc water;
    water.name = "water";
    FluidDesc f;
    f.material = *w.add_material(water);
    f.shape = Shape::box({0, 0, 0}, {1, 0.8, 1});
    require(w.add_fluid(f));
    SolidDesc s = on_path(*w.add_material(stone()),
                          {{0.1, {}, 0}, {0.25, {0.05, 0, 0}, 0.3}, {0.3, {0, 0.05, 0}, 0}});
    s.shape = Shape::box({0.3, 0.3, 0.3}, {0.6, 0.6, 0.6});
    require(w.add_solid(s));
    return w;
  };
  World w = begin();
  for (int k = 0; k < 4; ++k) require(w.step(0.05));
  const auto state = *w.snapshot();
  const auto saved = *w.save();
  for (int k = 0; k < 4; ++k) require(w.step(0.05));
  const std::uint64_t hash = *w.state_hash();
  require(w.restore(state.data(), state.size()));
  for (int k = 0; k < 4; ++k) require(w.step(0.05));
  EXPECT_EQ(*w.state_hash(), hash);
  World other = begin();
  require(other.load_saved(saved.data(), saved.size()));  // the body that comes along has its path
  for (int k = 0; k < 4; ++k) require(other.step(0.05));
  EXPECT_EQ(*other.state_hash(), hash);
}

TEST(Steering, SetMotionEndsAPath) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(steered_desc({2, 2, 2}));
  const BodyId block = *w.add_solid(on_path(*w.add_material(stone()), there_and_back(0)));
  require(w.step(1));
  const Vec3d at = *w.motion(block)->position;
  require(w.set_motion(block, moves_at({0, 0.1, 0})));
  require(w.step(2));
  EXPECT_LT(distance(*w.motion(block)->position, at + Vec3d{0, 0.2, 0}), 1e-12);
}

TEST(Steering, RefusesPathsThatCannotBe) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(steered_desc({2, 2, 2}));
  const MaterialId m = *w.add_material(stone());
  const auto with = [&](const std::function<void(SolidDesc&)>& change) {
    SolidDesc s = on_path(m, there_and_back(1));
    change(s);
    return w.add_solid(s);
  };
  const auto refused = [](const Result<BodyId>& r, const std::string& part) {
    ASSERT_FALSE(r) << part;
    EXPECT_EQ(r.error().code, ErrorCode::invalid_argument);
    EXPECT_NE(r.error().message.find(part), std::string::npos) << r.error().message;
  };
  require(w.step(0.5));
  refused(with([](SolidDesc& s) { s.motion = Motion::free; }), "path: only of kinematic bodies");
  refused(with([](SolidDesc& s) { s.velocity = {1, 0, 0}; }), "drop these");
  refused(with([](SolidDesc& s) { s.path_axis = {}; }), "path_axis: must be finite and not 0");
  refused(with([](SolidDesc& s) { s.path[0].displacement.x = 1; }), "let that point be 0 m and 0 rad");
  refused(with([](SolidDesc& s) { s.path[0].angle = 1; }), "let that point be 0 m and 0 rad");
  refused(with([](SolidDesc& s) { s.path[0].time = 0.4; }), "let it begin now or later");
  refused(with([](SolidDesc& s) { s.path[2].time = s.path[1].time; }), "times must ascend");
  refused(with([](SolidDesc& s) { s.path[2].angle = infinity; }), "must be finite");
  refused(with([](SolidDesc& s) { s.path[1].displacement.x = 1e300; }), "m/s");
  // Through a wall: the step that would take it there is refused, the one before it not, and the World waits.
  require(with([](SolidDesc& s) { s.path[1].displacement.x = 2; }));
  require(w.step(0.6));
  const Status s = w.step(3);
  ASSERT_FALSE(s);
  EXPECT_NE(s.error().message.find("path"), std::string::npos) << s.error().message;
  EXPECT_NE(s.error().message.find("through a wall"), std::string::npos) << s.error().message;
  EXPECT_EQ(w.time(), 1.1);
}

// A motion that a step refuses does not stop the World: the body goes on as it did before, at 0.1 m/s along y.
TEST(Steering, ForgetsAMotionThatAStepRefuses) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = steered_desc({2, 2, 2});
  World w = make(d);
  const BodyId block =
      kinematic(w, *w.add_material(stone()), Shape::box({0.8, 0.4, 0.8}, {1.2, 0.8, 1.2}), {0, 0.1, 0});
  require(w.step(0.1));
  const BodyMotion before = *w.motion(block);
  require(w.set_motion(block, goes_to({1, 5, 1})));
  const Status refused = w.step(0.1);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("through a wall"), std::string::npos) << refused.error().message;
  EXPECT_EQ(w.time(), 0.1);
  require(w.step(0.1));
  const BodyMotion after = *w.motion(block);
  EXPECT_NEAR(after.position->y - before.position->y, 0.01, 1e-12);
  EXPECT_EQ(after.velocity.y, 0.1);
}

TEST(Steering, RefusesWhatCannotBeAndChangesNothing) {
  MELTSIM_NEEDS_BACKEND();
  Paddle a = paddle_in_water(), other = paddle_in_water();
  World& w = a.world;
  SolidDesc s;
  s.name = "block";
  s.material = *w.add_material([] {
    MaterialDesc m = stone();
    m.name = "brick";
    return m;
  }());
  s.shape = Shape::box({0.4, 0.9, 0.4}, {0.8, 1.1, 0.8});
  s.fixed = true;
  const BodyId block = *w.add_solid(s);
  require(w.step(0.01));
  const std::uint64_t hash = *w.state_hash();
  const double nan = std::nan("");
  const auto with = [](const std::function<void(BodyMotion&)>& change) {
    BodyMotion m;
    change(m);
    return m;
  };
  const struct {
    const char* names;
    BodyId body;
    BodyMotion motion;
  } bad[] = {
      {"position", a.paddle, goes_to({nan, 0, 0})},
      {"velocity", a.paddle, moves_at({infinity, 0, 0})},
      {"angular_velocity", a.paddle, moves_at({}, {0, nan, 0})},
      {"orientation", a.paddle, with([](BodyMotion& m) {
         m.orientation = Quat<double>{2, 0, 0, 0};
       })},
      {"orientation", a.paddle, with([&](BodyMotion& m) {
         m.orientation = Quat<double>{nan, 0, 0, 0};
       })},
      {"kinematic", block, moves_at({1, 0, 0})},
      {"body: no body of this World", other.paddle, moves_at({1, 0, 0})},
      {"body: no body of this World", BodyId{}, moves_at({1, 0, 0})},
      {"teleport", a.paddle, with([](BodyMotion& m) { m.teleport = true; })},
      {"block", a.paddle, with([](BodyMotion& m) {
         m.teleport = true;
         m.position = Vec3d{0.6, 1.0, 0.6};
       })},
      {"through a wall", a.paddle, with([](BodyMotion& m) {
         m.teleport = true;
         m.position = Vec3d{0.1, 1.0, 0.6};
       })},
  };
  for (const auto& b : bad) {
    const Status r = w.set_motion(b.body, b.motion);
    ASSERT_FALSE(r) << b.names;
    EXPECT_EQ(r.error().code, ErrorCode::invalid_argument);
    EXPECT_NE(r.error().message.find(b.names), std::string::npos) << r.error().message;
  }
  EXPECT_FALSE(w.motion(block));
  // What only a step can tell: too fast for the sound speed of 40 m/s, or through the wall at the end.
  for (const auto& [motion, names] :
       {std::pair<BodyMotion, const char*>{moves_at({25, 0, 0}), "sound speed"},
        std::pair<BodyMotion, const char*>{goes_to({0.2, 0.4, 0.6}), "through a wall"}}) {
    require(w.set_motion(a.paddle, motion));
    const Status r = w.step(0.1);
    ASSERT_FALSE(r) << names;
    EXPECT_EQ(r.error().code, ErrorCode::invalid_argument);
    EXPECT_NE(r.error().message.find(names), std::string::npos) << r.error().message;
  }
  EXPECT_EQ(*w.state_hash(), hash);
  require(w.set_motion(a.paddle, moves_at({})));
  require(w.step(0.01));

  SolidDesc wrong = s;
  wrong.name = "wrong";
  wrong.shape = Shape::box({0, 1, 0}, {0.2, 1.1, 0.2});
  wrong.motion = Motion::kinematic;  // beside fixed
  EXPECT_FALSE(w.add_solid(wrong));
  wrong.fixed = false;
  wrong.max_speed = -1;
  EXPECT_FALSE(w.add_solid(wrong));
  wrong.motion = Motion::fixed;
  wrong.max_speed = 1;
  EXPECT_FALSE(w.add_solid(wrong));
}

/// A warm tank with a block of ice in it, a held region and a heated floor.
struct Tank {
  World world;
  HeatRegionId region;
  MaterialId water, ice;
};
struct Settings {
  Vec3d gravity{0, -9.81, 0};
  double time_scale = 500, held = 60, source = 0;
  bool holds = true;
  double viscosity = 1e-3, conductivity = 0.6, stiffness = 1;  // of the water, of the ice
  SurfaceHeatDesc floor, side;
};
Tank make_tank(const Settings& s) {
  WorldDesc d = steered_desc({1, 1, 1});
  d.heat.model = HeatModel::enthalpy;
  d.heat.time_scale = s.time_scale;
  d.gravity = s.gravity;
  d.domain.heat[2] = s.floor;
  d.domain.heat[0] = s.side;
  World w = make(d);
  MaterialDesc liquid;
  liquid.viscosity = s.viscosity;
  liquid.conductivity = s.conductivity;
  const MaterialId water = *w.add_material(liquid);
  MaterialDesc ice;
  ice.name = "ice";
  ice.density = 917;
  ice.stiffness = s.stiffness;
  ice.melts_into = water;
  ice.melting_point = 0;
  ice.latent_heat = 3.34e5;
  SolidDesc b;
  b.material = *w.add_material(ice);
  b.shape = Shape::box({0.3, 0.3, 0.3}, {0.7, 0.6, 0.7});
  b.temperature = -5;
  require(w.add_solid(b));
  FluidDesc f;
  f.material = water;
  f.shape = Shape::box({0, 0, 0}, {1, 0.5, 1});
  f.temperature = 30;
  require(w.add_fluid(f));
  HeatRegionDesc r;
  r.shape = Shape::box({0, 0, 0}, {0.2, 1, 1});
  if (s.holds) r.temperature = s.held;
  r.source = s.source;
  const HeatRegionId region = *w.add_heat_region(r);
  return {std::move(w), region, water, b.material};
}

// A World whose settings were changed is the World that was built with them and given the state, to the last bit.
TEST(Steering, ChangedSettingsAreThoseOfAWorldBuiltWithThem) {
  MELTSIM_NEEDS_BACKEND();
  Settings cooled;
  cooled.floor.convection = 200;
  cooled.floor.ambient = 90;
  const auto change = [](const std::function<void(Settings&)>& what, Settings s = {}) {
    what(s);
    return s;
  };
  const struct {
    const char* name;
    Settings before, after;
    std::function<Status(Tank&)> steer;
  } cases[] = {
      {"gravity",
       {},
       change([](Settings& s) {
         s.gravity = {3, -8, 1};
       }),
       [](Tank& t) {
         return t.world.set_gravity({3, -8, 1});
       }},
      {"time scale",
       {},
       change([](Settings& s) { s.time_scale = 900; }),
       [](Tank& t) { return t.world.set_heat_time_scale(900); }},
      {"no heat",
       {},
       change([](Settings& s) { s.time_scale = 0; }),
       [](Tank& t) { return t.world.set_heat_time_scale(0); }},
      {"floor", cooled, change([](Settings& s) { s.floor.ambient = -20; }, cooled),
       [](Tank& t) {
         SurfaceHeatDesc h;
         h.convection = 200;
         h.ambient = -20;
         return t.world.set_wall_heat(2, h);
       }},
      {"another wall", cooled, change([](Settings& s) { s.side.temperature = 70; }, cooled),
       [](Tank& t) {
         SurfaceHeatDesc h;
         h.temperature = 70;
         return t.world.set_wall_heat(0, h);
       }},
      {"region",
       {},
       change([](Settings& s) { s.held = 5; }),
       [](Tank& t) { return t.world.set_heat_region(t.region, 5.0); }},
      {"region's source",
       {},
       change([](Settings& s) {
         s.holds = false;
         s.source = 2e5;
       }),
       [](Tank& t) { return t.world.set_heat_region(t.region, std::nullopt, 2e5); }},
      {"viscosity and conductivity",
       {},
       change([](Settings& s) {
         s.viscosity = 5;  // implicit then: other stages
         s.conductivity = 3;
       }),
       [](Tank& t) {
         MaterialDesc m = t.world.material(t.water);
         m.viscosity = 5;
         m.conductivity = 3;
         return t.world.set_material(t.water, m);
       }},
      {"stiffness",
       {},
       change([](Settings& s) { s.stiffness = 0.6; }),
       [](Tank& t) {
         MaterialDesc m = t.world.material(t.ice);
         m.stiffness = 0.6;
         return t.world.set_material(t.ice, m);
       }},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.name);
    Tank steered = make_tank(c.before), built = make_tank(c.after), left = make_tank(c.before);
    for (int k = 0; k < 3; ++k) require(steered.world.step(0.01));
    const std::vector<std::uint8_t> state = *steered.world.snapshot();
    require(steered.world.step(0.01));
    require(c.steer(steered));
    require(steered.world.restore(state.data(), state.size()));
    require(built.world.restore(state.data(), state.size()));
    require(left.world.restore(state.data(), state.size()));
    // And once more without anything that a restore() uploads: it was steered while it ran.
    Tank running = make_tank(c.before);
    for (int k = 0; k < 3; ++k) require(running.world.step(0.01));
    require(c.steer(running));
    for (int k = 0; k < 4; ++k)
      for (World* w : {&steered.world, &built.world, &left.world, &running.world}) require(w->step(0.01));
    EXPECT_EQ(*steered.world.state_hash(), *built.world.state_hash());
    EXPECT_EQ(*running.world.state_hash(), *built.world.state_hash());
    EXPECT_NE(*left.world.state_hash(), *built.world.state_hash());
  }
}

// Gravity travels with the sub-step: a stone in the void has the velocity sum of g dt, to the rounding of 40 additions;
// readings weigh it by the gravity of the moment, and no graph is recorded for it.
TEST(Steering, GravityChangesInEveryStep) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = steered_desc({});
  d.domain.bounded = false;
  World w = make(d);
  SolidDesc s;
  s.material = *w.add_material(stone());
  s.shape = Shape::box({0, 0, 0}, {0.3, 0.3, 0.3});
  require(w.add_solid(s));
  Vec3d v;
  std::uint64_t graphs = 0;
  for (int k = 0; k < 40; ++k) {
    const Vec3d g{std::sin(0.3 * k), std::cos(0.3 * k), 0.1 * k};
    require(w.set_gravity(g));
    require(w.step(2e-3));
    v += g * 2e-3;
    if (k == 5) graphs = w.plan().graphs;
  }
  EXPECT_EQ(w.plan().graphs, graphs);
  const auto pieces = *w.pieces();
  EXPECT_LT(distance(pieces.at(0).velocity, v), 1e-12);
  require(w.set_gravity({0, 0, -2}));
  EXPECT_NEAR(w.totals()->potential, 27 * 2.0 * 2 * w.totals()->solid_center.z, 1e-9);
}

// A gravity that would make liquid fall faster than the sound speed was chosen for raises it; a smaller one leaves it.
TEST(Steering, MoreGravityMakesSoundFaster) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = steered_desc({1, 1, 2});
  d.sound_speed = 0;
  d.gravity = {0, -1, 0};
  World w = make(d);
  FluidDesc f;
  f.material = *w.add_material({});
  f.shape = Shape::box({0, 0, 0}, {1, 0.5, 2});
  require(w.add_fluid(f));
  require(w.step(0.01));
  EXPECT_NEAR(w.resolved().sound_speed, 10 * std::sqrt(2 * 1 * 0.55),
              1e-9);  // half a spacing above and below centres
  require(w.set_gravity({0, -4, 0}));
  require(w.step(0.01));
  EXPECT_NEAR(w.resolved().sound_speed, 10 * std::sqrt(2 * 4 * 0.55), 1e-9);
  require(w.set_gravity({0, 0, -4}));
  require(w.step(0.01));
  EXPECT_NEAR(w.resolved().sound_speed, 10 * std::sqrt(2 * 4 * 2.05), 1e-9);
  require(w.set_gravity({0, 0, -1}));
  require(w.step(0.01));
  EXPECT_NEAR(w.resolved().sound_speed, 10 * std::sqrt(2 * 4 * 2.05), 1e-9);
  EXPECT_FALSE(w.synchronize().halted);
}

TEST(Steering, RefusesSettingsThatCannotBe) {
  MELTSIM_NEEDS_BACKEND();
  Tank t = make_tank({}), other = make_tank({});
  Paddle dry = paddle_in_water();
  require(t.world.step(0.01));
  const std::uint64_t hash = *t.world.state_hash();
  SurfaceHeatDesc hot, wrong;
  hot.temperature = 50;
  const auto as = [&](MaterialId id, auto what) {
    MaterialDesc m = t.world.material(id);
    what(m);
    return t.world.set_material(id, m);
  };
  wrong.emissivity = 2;
  const struct {
    const char* names;
    Status refused;
  } bad[] = {
      {"gravity", t.world.set_gravity({0, std::nan(""), 0})},
      {"time_scale", t.world.set_heat_time_scale(-1)},
      {"time_scale", t.world.set_heat_time_scale(infinity)},
      {"face", t.world.set_wall_heat(6, hot)},
      {"emissivity", t.world.set_wall_heat(2, wrong)},
      {"heat.model", dry.world.set_wall_heat(2, hot)},
      {"region", t.world.set_heat_region(other.region, 3.0)},
      {"temperature", t.world.set_heat_region(t.region, -300.0)},
      {"source", t.world.set_heat_region(t.region, 3.0, 5.0)},
      {"source", t.world.set_heat_region(t.region, std::nullopt, std::nan(""))},
      {"density: must stay", as(t.water, [](MaterialDesc& m) { m.density = 900; })},
      {"melting_point: must stay", as(t.ice, [](MaterialDesc& m) { m.melting_point = 5; })},
      {"freezes: must stay", as(t.ice, [](MaterialDesc& m) { m.freezes = true; })},
      {"viscosity", as(t.water, [](MaterialDesc& m) { m.viscosity = -1; })},
      {"material", t.world.set_material({}, {})},
  };
  for (const auto& b : bad) {
    ASSERT_FALSE(b.refused) << b.names;
    EXPECT_EQ(b.refused.error().code, ErrorCode::invalid_argument);
    EXPECT_NE(b.refused.error().message.find(b.names), std::string::npos) << b.refused.error().message;
  }
  EXPECT_EQ(*t.world.state_hash(), hash);
  EXPECT_EQ(t.world.desc().heat.time_scale, 500);
}

// A cube of 27 particles of 2 kg, 0.1 m apart: M = 54 kg and, about any axis, I = 2 kg (18 + 18) (0.1 m)^2 = 0.72 kg m^2. An
// impulse J makes it J/M faster, an angular impulse L turns it L/I faster; to the rounding of double, before and, as no force
// acts on it, after steps in which shape matching keeps both (exact sums, 1e-8).
TEST(Steering, ImpulsesMoveAFreeBody) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = steered_desc({});
  d.domain.bounded = false;
  d.gravity = {};
  World w = make(d);
  SolidDesc s;
  s.material = *w.add_material(stone());
  s.shape = Shape::box({0, 0, 0}, {0.3, 0.3, 0.3});
  const BodyId body = *w.add_solid(s);
  s.shape = Shape::box({1, 0, 0}, {1.3, 0.3, 0.3});
  const BodyId other = *w.add_solid(s);
  const auto expect = [&](Vec3d v, Vec3d spin, double tolerance) {
    const auto pieces = *w.pieces();
    for (const PieceInfo& p : pieces) {
      const bool pushed = p.body == body;
      EXPECT_LT(distance(p.velocity, pushed ? v : Vec3d{}), tolerance);
      EXPECT_LT(distance(p.angular_velocity, pushed ? spin : Vec3d{}), 10 * tolerance);
    }
    EXPECT_EQ(pieces.size(), 2u);
    EXPECT_TRUE(pieces[0].body == body && pieces[1].body == other);
  };
  require(w.apply_impulse(body, {54, -27, 0}, {0, 0, 0.72}));
  expect({1, -0.5, 0}, {0, 0, 1}, 1e-13);
  require(w.apply_impulse(body, {0, 27, 5.4}, {0.36, 0, 0}));
  expect({1, 0, 0.1}, {0.5, 0, 1}, 1e-13);
  require(w.set_velocity(body, {0, 0.3, 0}, {0, 2, 0}));
  expect({0, 0.3, 0}, {0, 2, 0}, 1e-13);
  const Vec3d spun = w.totals()->angular_momentum;
  for (int k = 0; k < 20; ++k) require(w.step(2e-3));
  EXPECT_LT(distance(w.pieces()->at(0).velocity, {0, 0.3, 0}), 1e-7);
  EXPECT_LT(distance(w.totals()->angular_momentum, spun), 1e-7);
}

TEST(Steering, RefusesPushesOnWhatForcesDoNotMove) {
  MELTSIM_NEEDS_BACKEND();
  Paddle a = paddle_in_water();
  World& w = a.world;
  SolidDesc s;
  s.material = *w.add_material([] {
    MaterialDesc m = stone();
    m.name = "brick";
    return m;
  }());
  s.shape = Shape::box({0.4, 0.9, 0.4}, {0.8, 1.1, 0.8});
  const BodyId block = *w.add_solid(s);
  require(w.step(0.01));
  const std::uint64_t hash = *w.state_hash();
  const double nan = std::nan("");
  for (const Status& r : {w.apply_impulse(a.paddle, {1, 0, 0}), w.set_velocity(a.paddle, {1, 0, 0}),
                          w.apply_impulse(BodyId{}, {1, 0, 0}), w.apply_impulse(block, {nan, 0, 0}),
                          w.apply_impulse(block, {}, {0, infinity, 0}), w.set_velocity(block, {0, nan, 0}),
                          w.set_velocity(block, {}, {1e300, 0, 0}), w.apply_impulse(block, {1e308, 0, 0})}) {
    ASSERT_FALSE(r);
    EXPECT_EQ(r.error().code, ErrorCode::invalid_argument) << r.error().message;
  }
  EXPECT_EQ(*w.state_hash(), hash);
}

/// A nozzle in the void: layers of 8 points (R = 1.5 spacings), 8/7.07 spacings apart.
struct Jet {
  World world;
  EmitterId emitter;
};
constexpr double layer_distance = 8 * 0.001 / (pi * 0.15 * 0.15);
Jet jet(std::uint64_t most = 0) {
  WorldDesc d = steered_desc({});
  d.domain.bounded = false;
  d.gravity = {};
  d.heat.model = HeatModel::enthalpy;
  World w = make(d);
  EmitterDesc e;
  e.material = *w.add_material({});
  e.axis = {1, 0, 0};
  e.radius = 0.15;
  e.speed = 1;
  e.until = 1;
  e.max_particles = most;
  const EmitterId id = *w.add_emitter(e);
  return {std::move(w), id};
}
std::size_t layers_of(World& w) { return w.particles()->id.size() / 8; }

TEST(Steering, EmittersChangeSpeedTemperatureAndStop) {
  MELTSIM_NEEDS_BACKEND();
  Jet a = jet();
  EmitterSetting faster, off, on;
  faster.speed = 2.5;
  faster.temperature = 70;
  off.on = false;
  on.on = true;
  const auto steps = [&](Jet& j, int n) {
    for (int k = 0; k < n; ++k) require(j.world.step(0.01));
  };
  steps(a, 30);
  require(a.world.set_emitter(a.emitter, faster));
  const std::size_t cold = layers_of(a.world);
  steps(a, 30);
  EXPECT_EQ(layers_of(a.world), 1 + static_cast<std::size_t>((0.3 * 1 + 0.3 * 2.5) / layer_distance));
  const ParticleData p = *a.world.particles();
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    EXPECT_NEAR(p.temperature[i], p.id[i] / 8 < cold ? 20 : 70, 1) << p.id[i];
    // In the pipe, two spacings long from x = -0.2 on, it moves as the nozzle does.
    if (is_held(p.tag[i])) {
      EXPECT_NEAR(p.velocity[i].x, 2.5, 1e-12);
      const double way = 2.5 * (a.world.time() - 0.3) + 0.3 - double(p.id[i] / 8) * layer_distance;
      EXPECT_NEAR(p.position[i].x + 2 * layer_distance, way, 1e-9);
    }
  }
  // Off: those in the pipe still leave it. What it leaves out counts towards nothing.
  require(a.world.set_emitter(a.emitter, off));
  const std::size_t before = layers_of(a.world);
  steps(a, 20);
  EXPECT_EQ(layers_of(a.world), before);
  const ParticleData left = *a.world.particles();
  for (const ParticleTag tag : left.tag) EXPECT_FALSE(is_held(tag));
  require(a.world.set_emitter(a.emitter, on));
  // In mid-change a snapshot goes on with the same bits, also where the setting was another one.
  const std::vector<std::uint8_t> state = *a.world.snapshot();
  Jet b = jet();
  require(b.world.restore(state.data(), state.size()));
  steps(a, 15);
  steps(b, 15);
  EXPECT_GT(layers_of(a.world), before);
  EXPECT_EQ(*a.world.state_hash(), *b.world.state_hash());
  steps(a, 30);  // its end, 1 s, is past
  const std::size_t all = layers_of(a.world);
  steps(a, 10);
  EXPECT_EQ(layers_of(a.world), all);
  EXPECT_FALSE(a.world.synchronize().halted);

  Jet c = jet(24);
  require(c.world.set_emitter(c.emitter, off));
  steps(c, 50);
  EXPECT_EQ(layers_of(c.world), 0u);
  require(c.world.set_emitter(c.emitter, on));
  steps(c, 50);
  EXPECT_EQ(layers_of(c.world), 3u);
}

// A tap that the host moves: what it holds moves with it, and what it lets go of falls where it is then. Layers are those of a tap at
// rest: the same particles, as many, at the place of the tap by the distance moved, to rounding.
TEST(Steering, AnEmitterMovesWithWhatItHolds) {
  MELTSIM_NEEDS_BACKEND();
  const auto tap = [](bool moves) {
    WorldDesc d = steered_desc({4, 4, 4});
    d.gravity = {};
    World w = make(d);
    EmitterDesc e;
    e.material = *w.add_material({});
    e.center = {1, 3, 2};
    e.radius = 0.25;
    e.speed = 2;
    e.until = 1;
    const EmitterId id = *w.add_emitter(e);
    for (int k = 0; k < 20; ++k) {
      require(w.step(0.01));
      EmitterSetting to;
      to.center = Vec3d{1 + 0.05 * (k + 1), 3, 2};
      if (moves) require(w.set_emitter(id, to));
    }
    return std::pair{std::move(w), id};
  };
  auto [still, a] = tap(false);
  auto [moved, b] = tap(true);
  const ParticleData p = *still.particles(), q = *moved.particles();
  ASSERT_EQ(p.id, q.id);
  ASSERT_GT(p.id.size(), 50u);
  int held = 0, free = 0;
  double last = 0;
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    const Vec3d by = q.position[i] - p.position[i];
    if (is_held(q.tag[i])) {
      EXPECT_LT(length(by - Vec3d{1, 0, 0}), 1e-9) << "what is in the pipe is where the pipe is";
      EXPECT_LT(length(q.velocity[i] - Vec3d{0, -2, 0}), 1e-12);
      ++held;
    } else {
      EXPECT_LT(by.x, 1.05);  // a layer that spreads a little differently
      EXPECT_GT(by.x, 0.05);
      last = std::max(last, by.x);
      ++free;
    }
  }
  EXPECT_GT(held, 10);
  EXPECT_GT(free, 20);
  EXPECT_GT(last, 0.7);
  const auto snapshot = *moved.snapshot();
  for (int k = 0; k < 5; ++k) require(moved.step(0.01));
  const std::uint64_t end = *moved.state_hash();
  EmitterSetting back;
  back.center = Vec3d{1, 3, 2};
  require(moved.set_emitter(b, back));
  require(moved.restore(snapshot.data(), snapshot.size()));  // the place is part of the state
  for (int k = 0; k < 5; ++k) require(moved.step(0.01));
  EXPECT_EQ(*moved.state_hash(), end);
  EmitterSetting bad;
  for (const auto& [center, word] :
       {std::pair{Vec3d{0, 3, 2}, "reaches into a wall"},
        std::pair{Vec3d{9, 3, 2}, "wall or out of the domain"}, std::pair{Vec3d{infinity, 3, 2}, "finite"},
        std::pair{Vec3d{1, 3.95, 2}, "pipe begins"}}) {
    bad.center = center;
    const Status s = moved.set_emitter(b, bad);
    ASSERT_FALSE(s) << word;
    EXPECT_NE(s.error().message.find(word), std::string::npos) << s.error().message;
  }
  EXPECT_EQ(*moved.state_hash(), end);
}

TEST(Steering, RefusesEmittersThatCannotBe) {
  MELTSIM_NEEDS_BACKEND();
  Jet a = jet(), other = jet();
  require(a.world.step(0.01));
  EmitterSetting slow, cold, fast;
  slow.speed = 0;
  cold.temperature = -300;
  fast.speed = infinity;
  for (const Status& r : {a.world.set_emitter(a.emitter, slow), a.world.set_emitter(a.emitter, cold),
                          a.world.set_emitter(a.emitter, fast), a.world.set_emitter(other.emitter, {}),
                          a.world.set_emitter(EmitterId{}, {})}) {
    ASSERT_FALSE(r);
    EXPECT_EQ(r.error().code, ErrorCode::invalid_argument) << r.error().message;
  }
  require(a.world.set_emitter(a.emitter, {}));
}

// What is removed is gone, what has melted off a body stays, and all goes on, here and in a World that is given the state.
TEST(Steering, RemovesBodiesAndLiquid) {
  MELTSIM_NEEDS_BACKEND();
  Paddle a = paddle_in_water(), b = paddle_in_water();
  World& w = a.world;
  require(w.step(0.01));
  const Totals before = *w.totals();
  EXPECT_EQ(before.solid, 6u * 4 * 2);
  const Shape half = Shape::box({0, 0, 0}, {1.2, 1.2, 0.6});
  const ParticleData p = *w.particles();
  std::size_t inside = 0;
  for (std::size_t i = 0; i < p.id.size(); ++i)
    inside += is_fluid(p.tag[i]) && p.position[i].z <= 0.6 ? 1u : 0u;
  ASSERT_GT(inside, 300u);
  EXPECT_EQ(*w.remove_liquid(half), inside);
  EXPECT_EQ(*w.remove_liquid(half), 0u);
  EXPECT_FALSE(w.remove_liquid(Shape::box({1, 0, 0}, {0, 1, 1})));
  require(w.step(0.01));
  EXPECT_EQ(w.totals()->fluid, before.fluid - inside);
  require(w.remove(a.paddle));
  const Status again = w.remove(a.paddle);
  ASSERT_FALSE(again);
  EXPECT_NE(again.error().message.find("was removed"), std::string::npos) << again.error().message;
  EXPECT_FALSE(w.remove(b.paddle));  // of another World
  EXPECT_FALSE(w.set_motion(a.paddle, {}));
  for (int k = 0; k < 5; ++k) require(w.step(0.01));
  const StepResult r = w.synchronize();
  EXPECT_FALSE(r.halted) << r.halt_reason;
  EXPECT_EQ(r.solid, 0u);
  EXPECT_EQ(r.fluid, before.fluid - inside);
  EXPECT_EQ(r.removed, inside + 48);
  EXPECT_TRUE(w.pieces()->empty());
  const std::vector<std::uint8_t> state = *w.snapshot();
  require(b.world.restore(state.data(), state.size()));
  EXPECT_FALSE(b.world.remove(b.paddle));  // it is gone there, too
  for (World* x : {&w, &b.world}) require(x->step(0.01));
  EXPECT_EQ(*w.state_hash(), *b.world.state_hash());
}

TEST(Steering, RemovesOneBodyOfTwo) {
  MELTSIM_NEEDS_BACKEND();
  IceScene s;
  s.ice_temperature = -0.1;
  Scene scene = ice_in_water(describe(), s);
  World& w = scene.world;
  // Until something has melted, which stays.
  StepResult r = w.synchronize();
  for (int k = 0; k < 200 && r.melted == 0; ++k) {
    require(w.step(0.005));
    r = w.synchronize();
  }
  ASSERT_GT(r.melted, 0u);
  ASSERT_GT(r.solid, 0u);
  const auto body = w.pieces()->at(0).body;
  require(w.remove(body));
  for (int k = 0; k < 5; ++k) require(w.step(0.005));
  const StepResult after = w.synchronize();
  EXPECT_FALSE(after.halted) << after.halt_reason;
  EXPECT_EQ(after.solid, 0u);
  EXPECT_EQ(after.fluid, r.fluid);
  EXPECT_EQ(after.melted, r.melted);
}

// Into clear air it may jump, and is at rest there.
TEST(Steering, TeleportsWhereNothingIs) {
  MELTSIM_NEEDS_BACKEND();
  Paddle a = paddle_in_water();
  require(a.world.step(0.01));
  BodyMotion m = goes_to({0.6, 0.95, 0.6});
  m.orientation = turned(0);
  m.teleport = true;
  require(a.world.set_motion(a.paddle, m));
  require(a.world.step(0.01));
  EXPECT_LT(distance(*a.world.motion(a.paddle)->position, {0.6, 0.95, 0.6}), 1e-12);
  const ParticleData p = *a.world.particles();
  for (std::size_t i = 0; i < p.id.size(); ++i) {
    if (!is_solid(p.tag[i])) continue;
    EXPECT_GT(p.position[i].y, 0.7);
    EXPECT_EQ(length(p.velocity[i]), 0.0);
  }
  EXPECT_FALSE(a.world.synchronize().halted);
}

// It is elsewhere from the beginning of the step on: a block that lay on it falls freely in that very sub-step, at g dt to
// the exact sums of shape matching.
TEST(Steering, ATeleportIsOverBeforeTheStep) {
  MELTSIM_NEEDS_BACKEND();
  World w = make(steered_desc({1, 2, 1}));
  const MaterialId m = *w.add_material(stone());
  const BodyId plate = kinematic(w, m, Shape::box({0.1, 1, 0.1}, {0.9, 1.2, 0.9}));
  SolidDesc s;
  s.material = m;
  s.shape = Shape::box({0.4, 1.2, 0.4}, {0.7, 1.5, 0.7});
  const BodyId block = *w.add_solid(s);
  const auto speed = [&] {
    const auto pieces = *w.pieces();
    for (const PieceInfo& p : pieces)
      if (p.body == block) return p.velocity.y;
    return 1.0;
  };
  for (int k = 0; k < 400; ++k) require(w.step(2.5e-3));
  const double lying = speed();
  EXPECT_NEAR(lying, 0, 1e-3);
  BodyMotion away = goes_to({0.5, 0.5, 0.5});
  away.teleport = true;
  require(w.set_motion(plate, away));
  const double dt = 1e-3;  // one sub-step
  require(w.step(dt));
  EXPECT_NEAR(speed(), lying - 9.81 * dt, 1e-9);
}

// Its speed shortens sub-steps where nothing else does, and makes sound faster where it is said in advance.
TEST(Steering, LimitsFollowItsSpeed) {
  MELTSIM_NEEDS_BACKEND();
  WorldDesc d = steered_desc({4, 2, 2});
  d.gravity = {};
  d.sound_speed = 0;
  World w = make(d);
  SolidDesc s;
  s.material = *w.add_material(stone());
  s.shape = Shape::box({0.2, 0.2, 0.2}, {0.6, 0.6, 0.6});
  s.motion = Motion::kinematic;
  s.max_speed = 3;
  const BodyId b = *w.add_solid(s);
  EXPECT_NEAR(w.resolved().sound_speed, 30, 1e-9);
  require(w.set_motion(b, moves_at({3, 0, 0})));
  const std::uint64_t before = w.steps();
  require(w.step(1.0));
  const double H = w.resolved().support_radius;
  EXPECT_EQ(w.steps() - before, static_cast<std::uint64_t>(std::ceil(1.0 / (0.4 * H / 3) * (1 - 1e-9))));
}

}  // namespace
}  // namespace meltsim_test
