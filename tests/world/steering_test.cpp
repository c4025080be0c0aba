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
      {"liquid is in the way", a.paddle, with([](BodyMotion& m) {
         m.teleport = true;
         m.position = Vec3d{0.6, 0.4, 0.8};
       })},
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
  wrong.motion = Motion::free;
  wrong.max_speed = 1;
  EXPECT_FALSE(w.add_solid(wrong));
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
