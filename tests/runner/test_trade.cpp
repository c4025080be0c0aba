// SPDX-License-Identifier: Apache-2.0
// A scene as a problem of speed against accuracy: its observables, its settings, what is kept of a study.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "failure.hpp"
#include "files.hpp"
#include "frame_budget.hpp"
#include "load_scene.hpp"
#include "show/front_svg.hpp"
#include "trade_watch.hpp"

namespace runner {
namespace {

namespace trade = meltsim::trade;
using trade::Knob;
using trade::Knobs;

// Water that collapses: two hundred particles.
const std::string dam = R"(meltsim: 1
domain: {min: [0, 0, 0], max: [1, 0.8, 0.6], walls: box, no_slip: false}
particles: {spacing: 0.1}
time: {end: 0.1, fps: 50, stepping: adaptive}
heat: {model: none}
materials: {water: {density: 1000, viscosity: 0.05}}
fluids: [{shape: {box: [[0,0,0],[0.5,0.6,0.6]]}, material: water}]
probes: [{name: floor, at: [0.2, 0.05, 0.3], fields: [pressure]}, {name: gauge, kind: level, at: [0.1, 0.1, 0.3]}]
)";

// Ice and cork in a basin.
const std::string basin = R"(meltsim: 1
domain: {min: [0, 0, 0], max: [1.2, 1.2, 1.2], walls: box}
particles: {spacing: 0.1}
time: {dt: 0.002, end: 0.05, fps: 50}
heat: {time_scale: 1000}
materials:
  water: {density: 1000, viscosity: 0.2, conductivity: 0.6, heat_capacity: 4186}
  ice: {density: 900, melting_point: 0, latent_heat: 3.34e5, becomes: water}
  cork: {density: 200}
fluids: [{shape: {box: [[0,0,0],[1.2,0.6,1.2]]}, material: water, temperature: 40}]
bodies:
  - {name: block, shape: {box: [[0.1,0.5,0.1],[0.5,0.9,0.5]]}, material: ice, temperature: -10}
  - {name: raft, shape: {box: [[0.6,0.5,0.6],[1.0,0.8,1.0]]}, material: cork}
  - {name: post, fixed: true, shape: {box: [[0.9,0.2,0.1],[1.1,0.6,0.3]]}, material: cork}
)";

MachineOptions cpu() { return {meltsim::Backend::cpu, meltsim::Precision::single_precision, 1, 1}; }
Scene parse(const std::string& text, const std::vector<std::string>& set = {}) {
  return parse_scene(text, "made.yaml", "", set);
}

std::vector<std::string> names_of(const Tuning& tuning) {
  std::vector<std::string> names;
  for (const SceneObservable& o : tuning.observables()) names.push_back(o.desc.name);
  return names;
}

std::string failure_of(const std::string& text, const std::vector<std::string>& names,
                       const std::vector<std::string>& set = {}) {
  try {
    Tuning(parse(text, set), cpu(), names, "--observe");
  } catch (const Failure& failure) {
    return failure.what();
  }
  return "no failure";
}

TEST(Trade, ObservablesFollowFromWhatIsInTheScene) {
  using Names = std::vector<std::string>;
  EXPECT_EQ(names_of(Tuning(parse(dam), cpu(), {}, "")), (Names{"front", "height", "level@gauge"}));
  EXPECT_EQ(names_of(Tuning(parse(basin), cpu(), {}, "")), (Names{"melted", "melt_time_50"}));
  EXPECT_EQ(names_of(Tuning(parse(basin, {"heat.model=none"}), cpu(), {}, "")),
            (Names{"draught@block", "draught@raft"}));
  EXPECT_EQ(names_of(Tuning(parse(dam, {"trade.observe=[energy, pressure@floor]"}), cpu(), {}, "")),
            (Names{"energy", "pressure@floor"}));
}

TEST(Trade, WhatASceneCannotHaveIsRefusedWithTheReason) {
  EXPECT_EQ(failure_of(dam, {"melted"}), "--observe: melted: nothing in this scene can melt");
  EXPECT_EQ(failure_of(dam, {"draught"}), "--observe: draught: the scene has no bodies");
  EXPECT_EQ(failure_of(basin, {"draught"}), "--observe: draught: of which body? e.g. draught@block");
  EXPECT_EQ(failure_of(basin, {"path"}), "--observe: path: of which body? e.g. path@block");
  EXPECT_EQ(failure_of(dam, {"level"}), "--observe: level: at which probe? e.g. level@floor");
  EXPECT_EQ(failure_of(basin, {"draught@rafd"}),
            "--observe: draught@rafd: no body is named \"rafd\"; did you mean \"raft\"?");
  EXPECT_EQ(failure_of(basin, {"path@post"}), "--observe: path@post: body \"post\" is fixed");
  const std::vector<std::string> moved{"bodies[1].motion=kinematic"};
  EXPECT_EQ(failure_of(basin, {"draught@raft"}, moved),
            "--observe: draught@raft: body \"raft\" is moved as the scene says, with all settings alike");
  EXPECT_EQ(failure_of(basin, {"pressure@x"}), "--observe: pressure@x: the scene has no probes");
  EXPECT_EQ(failure_of(dam, {"temperature@floor"}),
            "--observe: temperature@floor: probe \"floor\" does not sample the temperature; add temperature "
            "to its fields");
  EXPECT_EQ(failure_of(dam, {"level@floor"}), "--observe: level@floor: probe \"floor\" is not of kind level");
  EXPECT_NE(failure_of(dam, {"heigt"}).find("did you mean \"height\"?"), std::string::npos);
  EXPECT_EQ(failure_of(dam, {}, {"trade.observe=[melted]"})
                .find("--set trade.observe=[melted]: trade.observe: melted: nothing"),
            0u);
}

TEST(Trade, KnobsChangeWhatTheySayAndNothingElse) {
  const Tuning tuning(parse(dam, {"solver.sound_speed=20"}), cpu(), {}, "");
  Knobs knobs;
  const Scene same = tuning.with(knobs);
  EXPECT_DOUBLE_EQ(same.world.spacing, 0.1);
  EXPECT_DOUBLE_EQ(same.world.sound_speed, 20);
  knobs[Knob::spacing] = 0.5;
  knobs[Knob::sound_speed] = 0.4;
  knobs[Knob::courant] = 2;
  const Scene scene = tuning.with(knobs);
  EXPECT_NEAR(scene.world.spacing, 0.05, 1e-12);
  EXPECT_DOUBLE_EQ(scene.world.sound_speed, 8);
  EXPECT_DOUBLE_EQ(scene.world.courant, 0.6);  // the most there is
  EXPECT_TRUE(scene.time.adaptive);
  EXPECT_FALSE(scene.time.dt);
  knobs.stir = 1;
  const meltsim::Vec3d g = tuning.with(knobs).world.gravity;
  EXPECT_EQ(g.y, -9.81);
  EXPECT_NEAR(g.x, 9.81e-4, 1e-12);
}

TEST(Trade, StirredStartsWithALevelBeyondAFaceCanBeBuilt) {
  const std::string channel = R"(meltsim: 1
domain: {min: [0, 0, 0], max: [1, 0.8, 0.6], walls: {+x: open, +y: open}, OUTLET}
particles: {spacing: 0.1}
heat: {model: none}
materials: {water: {density: 1000, viscosity: 0.05}}
fluids: [{shape: {box: [[0,0,0],[1,0.4,0.6]]}, material: water}]
EMITTER)";
  const auto stirred = [&](const std::string& outlet, const std::string& emitter) {
    std::string text = channel;
    text.replace(text.find(", OUTLET"), 8, outlet);
    text.replace(text.find("EMITTER"), 7, emitter);
    const Tuning tuning(parse(text), cpu(), {}, "");
    Knobs knobs;
    knobs.stir = 2;
    Scene scene = tuning.with(knobs);
    build_world(scene, cpu());  // throws where gravity is not along an axis
    return scene.world.gravity;
  };
  for (const meltsim::Vec3d& g :
       {stirred(", outlets: {+x: {level: 0.4}}", ""),
        stirred("", "emitters: [{reservoir: {face: +x, level: 0.4}, material: water}]\n")}) {
    EXPECT_EQ(g.x, 0);
    EXPECT_NEAR(g.y, -9.81 * 1.0002, 1e-12);
  }
  EXPECT_NEAR(stirred("", "").x, 9.81 * 2e-4, 1e-12);
}

TEST(Trade, FasterSoundLeavesTheViscosityThatArtificialViscosityAmountsTo) {
  const Tuning tuning(parse(dam, {"solver.artificial_viscosity=0.04"}), cpu(), {}, "");
  const auto at = [&](double multiple) {
    Knobs knobs;
    knobs[Knob::sound_speed] = multiple;
    return tuning.with(knobs).world.artificial_viscosity;
  };
  EXPECT_DOUBLE_EQ(at(2), 0.02);
  EXPECT_EQ(at(1), 0.04);
  EXPECT_EQ(at(0.5), 0.04);
  EXPECT_EQ(at(8), 0.01);  // what isotropic pressure needs
}

TEST(Trade, WhereABodyCanMoveStepsStayShorterAndSoundFaster) {
  const auto range = [](const std::string& scene, Knob knob) {
    const Tuning tuning(parse(scene, {"solver.courant=0.4"}), cpu(), {}, "");
    return tuning.problem().ranges[static_cast<std::size_t>(knob)];
  };
  EXPECT_DOUBLE_EQ(range(dam, Knob::courant).most, 0.6 / 0.4);
  EXPECT_DOUBLE_EQ(range(dam, Knob::sound_speed).least, 0.3);
  EXPECT_DOUBLE_EQ(range(basin, Knob::courant).most, 0.5 / 0.4);
  EXPECT_DOUBLE_EQ(range(basin, Knob::sound_speed).least, 0.5);
}

TEST(Trade, SpacingsAreChosenSoThatBodiesKeepTheirVolume) {
  const std::string block =
      "bodies=[{name: block, shape: {box: [[0.1,0.5,0.1],[0.5,0.9,0.5]]}, material: ice, temperature: -10}]";
  const Tuning tuning(parse(basin, {block}), cpu(), {}, "");
  for (const double x : {0.55, 0.7, 0.85, 1.25}) {
    Knobs knobs;
    knobs[Knob::spacing] = x;
    const double s = tuning.with(knobs).world.spacing;
    EXPECT_NEAR(s, 0.1 * x, 0.12 * 0.1 * x);
    const double cells = 0.4 / s;  // the cube's edge
    EXPECT_NEAR(cells, std::round(cells), 1e-6) << x;
  }
}

// Liquid from wall to wall, 8 layers of it.
const std::string tank = R"(meltsim: 1
domain: {min: [0, 0, 0], max: [1, 0.7, 0.3], walls: box, no_slip: false}
particles: {spacing: 0.05}
time: {end: 0.1, fps: 50, stepping: adaptive}
heat: {model: none}
materials: {water: {density: 1000, viscosity: 0.05}}
fluids: [{shape: {box: [[0,0,0],[1,0.4,0.3]]}, material: water}]
)";

// 0.5 m by 0.6 m by 0.6 m of liquid, whose cells fill the tank's width: of 0.048 m it would have 8 % too little volume, of 0.053 m 7 %, of 0.087 m 6 % too
// much. Within 12 % there are spacings of 3 % (a seventeenth: half a layer along one axis) and less.
TEST(Trade, SpacingsAreChosenSoThatLiquidKeepsItsVolume) {
  const Tuning tuning(parse(dam), cpu(), {}, "");
  for (const double x : {0.48, 0.53, 0.87}) {
    Knobs knobs;
    knobs[Knob::spacing] = x;
    Built built = build_world(tuning.with(knobs), cpu());
    const double mass = built.world.totals()->mass;
    EXPECT_NEAR(mass / (1000 * 0.5 * 0.6 * 0.6), 1, 0.03) << x << ": " << built.world.desc().spacing;
  }
}

// Cells fill what is between walls, so that layers alone are to fit: they do at a spacing within 7 % of each of these. Of whole spacings across as well, 2 to
// 3 % of the liquid would be too much.
TEST(Trade, SpacingsNeedNotFitBetweenWalls) {
  const Tuning tuning(parse(tank), cpu(), {"height"}, "");
  for (const double x : {0.6, 0.78, 1.014}) {
    Knobs knobs;
    knobs[Knob::spacing] = x;
    Built built = build_world(tuning.with(knobs), cpu());
    EXPECT_NEAR(built.world.totals()->mass, 1000 * 0.4 * 0.3, 1e-4) << x;
  }
}

// Balls on a lattice have a mass of their own at each spacing.
TEST(Trade, AllOfWhatMeltsIsOneAtAnySpacing) {
  const std::string ball =
      "bodies=[{\"name\": \"ball\", \"shape\": {\"sphere\": {\"center\": [0.6, 0.3, 0.6], \"radius\": "
      "0.22}}, "
      "\"material\": \"ice\", \"temperature\": 0, \"fixed\": true}]";
  Tuning tuning(parse(basin, {ball, "heat.time_scale=1e6", "time.end=0.3"}), cpu(), {"melted"}, "");
  std::vector<double> masses;
  for (const double spacing : {1.0, 0.8, 0.6}) {
    Knobs knobs;
    knobs[Knob::spacing] = spacing;
    Built built = build_world(tuning.with(knobs), cpu());
    masses.push_back(built.world.pieces()->front().mass);
    const trade::Measurement measured = tuning.measure(knobs, meltsim::infinity);
    ASSERT_TRUE(measured.complete) << measured.problem;
    EXPECT_NEAR(measured.values[0].back(), 1, 1e-4) << spacing;  // single precision adds up latent heat
  }
  // Else this test could not fail.
  EXPECT_LT(*std::min_element(masses.begin(), masses.end()), 0.98 * masses[0]);
}

TEST(Trade, AReaderTellsTheStartOfTheScene) {
  Scene scene = parse(dam, {"solver.hydrostatic_start=false"});  // its weight would press it together
  const Tuning tuning(scene, cpu(), {"front", "height", "energy", "volume"}, "");
  Built built = build_world(scene, cpu());
  built.probes = add_probes(built.world, built.body_ids, scene);
  ObservableReader reader = tuning.reader(built);
  EXPECT_TRUE(reader.wants_particles());
  meltsim::ReadRequest what;
  what.totals = what.pieces = what.particles = true;
  const auto ticket = built.world.request(what);
  const auto reading = built.world.take(*ticket);
  ASSERT_TRUE(reading);
  const std::vector<double> values = reader.values(reading->totals, reading->pieces, reading->particles, {});
  ASSERT_EQ(values.size(), 4u);
  EXPECT_NEAR(values[0], 0.5, 1e-5);  // the block's faces, as exactly as floats say it
  EXPECT_NEAR(values[1], 0.6, 1e-5);
  EXPECT_EQ(values[2], 0);
}

// Scales are those of the domain and the fall into it, and places count from the domain's corner, wherever that is.
TEST(Trade, WhereEmittersBringAllLiquidTheDomainIsTheScale) {
  const auto jet = [](double x) {
    return fmt::format(
        "meltsim: 1\ndomain: {{min: [{0}, 2, 0], max: [{1}, 3, 0.5]}}\nparticles: {{spacing: 0.05}}\n"
        "time: {{end: 0.5, fps: 20}}\nheat: {{model: none}}\nmaterials: {{water: {{viscosity: 0.01}}}}\n"
        "emitters: [{{nozzle: {{center: [{2}, 2.8, 0.25], radius: 0.11}}, speed: 1, material: water, until: "
        "1}}]\n"
        "probes: [{{name: low, at: [{2}, 2.05, 0.25], fields: [pressure]}}]\n",
        x, x + 1, x + 0.2);
  };
  for (const double x : {0.0, 10.0}) {
    const Tuning tuning(parse(jet(x)), cpu(), {"front", "height", "pressure@low"}, "");
    EXPECT_NEAR(tuning.observables()[0].desc.scale, 1, 1e-12);
    EXPECT_NEAR(tuning.observables()[1].desc.scale, 0.8, 1e-12);
    EXPECT_NEAR(tuning.observables()[2].desc.scale, 1000 * 9.81 * 0.8, 1e-6);
    Built built = build_world(parse(jet(x)), cpu());
    for (int k = 0; k < 10; ++k) ASSERT_TRUE(built.world.step(0.01));
    ObservableReader reader = tuning.reader(built);
    meltsim::ReadRequest what;
    what.totals = what.pieces = what.particles = true;
    const auto reading = built.world.take(*built.world.request(what));
    ASSERT_TRUE(reading);
    const std::vector<double> values =
        reader.values(reading->totals, reading->pieces, reading->particles, {});
    EXPECT_NEAR(values[0], 0.3, 0.06);  // of a jet of 0.11 m radius at 0.2 m
    EXPECT_NEAR(values[1], 0.85, 0.1);
  }
  EXPECT_EQ(names_of(Tuning(parse(jet(0), {"probes=[]"}), cpu(), {}, "")),
            (std::vector<std::string>{"front", "height"}));
}

TEST(Trade, ALevelBeyondAFaceIsTheHeightOfWhatComesIn) {
  const Tuning tuning(parse("meltsim: 1\ndomain: {min: [1, 0, 0], max: [3, 1, 0.5], walls: {+x: open}}\n"
                            "particles: {spacing: 0.05}\ntime: {end: 0.5}\nheat: {model: none}\n"
                            "materials: {water: {}}\n"
                            "emitters: [{reservoir: {face: +x, level: 0.4}, material: water}]\n"),
                      cpu(), {"front", "height"}, "");
  EXPECT_NEAR(tuning.observables()[0].desc.scale, 2, 1e-12);
  EXPECT_NEAR(tuning.observables()[1].desc.scale, 0.4, 1e-12);
}

/// One process has several Worlds of a scene: of a choice of settings and of the run that follows, of a notebook.
TEST(Probes, OfBodiesAreThoseOfTheirWorld) {
  const Scene scene =
      parse(basin, {"probes=[{\"name\": \"load\", \"kind\": \"force\", \"body\": \"raft\"}]"});
  for (int k = 0; k < 2; ++k) {
    Built built = build_world(scene, cpu());
    ASSERT_NO_THROW(built.probes = add_probes(built.world, built.body_ids, scene));
    ASSERT_TRUE(built.world.step(0.002));
    const auto samples = built.world.take_samples();
    ASSERT_TRUE(samples);
    ASSERT_EQ(samples->size(), 1u);
    EXPECT_FALSE(samples->at(0).values.empty());
  }
}

/// A cache of its own.
class TradeCache : public ::testing::Test {
 protected:
  void SetUp() override {
    directory_ =
        std::filesystem::temp_directory_path() / ("meltsim_trade_test_" + std::to_string(::getpid()));
    std::filesystem::create_directories(directory_);
    ::setenv("XDG_CACHE_HOME", directory_.c_str(), 1);
  }
  void TearDown() override {
    ::unsetenv("XDG_CACHE_HOME");
    std::filesystem::remove_all(directory_);
  }
  std::filesystem::path directory_;
};

TEST_F(TradeCache, AStudyIsTakenFromItTheSecondTimeAndGivesTheSameChoice) {
  const Scene scene = parse(dam);
  Tuning first(scene, cpu(), {}, ""), second(scene, cpu(), {}, ""),
      other(parse(dam, {"time.end=0.08"}), cpu(), {}, "");
  TuneOptions options;
  options.seconds = 60;  // probes of 0.1 s are planned for, as fine as they are made at all
  const trade::Study a = first.study(options);
  EXPECT_FALSE(first.from_cache());
  ASSERT_FALSE(a.cut_short);
  const trade::Study b = second.study(options);
  EXPECT_TRUE(second.from_cache());
  const auto one = trade::choose(a, "front", 0.1), two = trade::choose(b, "front", 0.1);
  ASSERT_TRUE(one && two);
  EXPECT_EQ(one->knobs.value, two->knobs.value);
  EXPECT_EQ(one->error, two->error);
  EXPECT_EQ(trade::delivered(a, 0, a.probes[0].actual, a.probes[0].values[0]).max,
            trade::delivered(b, 0, b.probes[0].actual, b.probes[0].values[0]).max);
  options.cache = false;
  second.study(options);
  EXPECT_FALSE(second.from_cache());
  // Not cached again, and not mixed up: one file, of this scene.
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(directory_ / "meltsim"), {}), 1);
  options.cache = true;
  other.study(options);
  EXPECT_FALSE(other.from_cache());
}

// A scene names mesh files: what they hold counts, in parts of shapes, too.
TEST_F(TradeCache, AnotherMeshUnderTheSameNameIsMeasuredAnew) {
  const std::string mesh = (directory_ / "lump.obj").string();
  const auto write = [&](double height) {
    std::string text;
    for (int corner = 0; corner < 8; ++corner)
      text += fmt::format("v {} {} {}\n", corner & 1 ? 0.5 : 0.0, corner & 2 ? height : 0.0,
                          corner & 4 ? 0.6 : 0.0);
    for (const char* face : {"1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"})
      text += fmt::format("f {}\n", face);
    write_file(mesh, text);
  };
  TuneOptions options;
  options.seconds = 60;
  for (const char* shape : {"{{mesh: {}}}", "{{union: [{{mesh: {}}}], transform: {{offset: [0, 0, 0]}}}}"}) {
    const auto scene = [&] {
      return parse(dam, {"fluids[0].shape=" + fmt::format(fmt::runtime(shape), mesh), "time.end=0.04"});
    };
    for (const double height : {0.6, 0.4}) {
      write(height);
      Tuning first(scene(), cpu(), {}, ""), second(scene(), cpu(), {}, "");
      first.study(options);
      EXPECT_FALSE(first.from_cache()) << height;
      second.study(options);
      EXPECT_TRUE(second.from_cache()) << height;
    }
  }
}

TEST_F(TradeCache, WhatCannotBeReadIsMeasuredAnew) {
  const Scene scene = parse(dam, {"time.end=0.04"});
  TuneOptions options;
  options.seconds = 60;
  Tuning first(scene, cpu(), {}, "");
  first.study(options);
  for (const auto& entry : std::filesystem::directory_iterator(directory_ / "meltsim"))
    std::filesystem::resize_file(entry.path(), 100);
  Tuning second(scene, cpu(), {}, "");
  second.study(options);
  EXPECT_FALSE(second.from_cache());
}

// A body that is heated evenly and loses nothing: its temperature is linear in time, so that whatever a probe says belongs to one
// time alone. With values taken for those of the sample's time the error was an interval between samples, 5 K here. Left are
// half a sub-step of the probe at every step, 0.25 K, and rounding in single precision.
TEST(Trade, ValuesOfAProbeBelongToTheTimesAtWhichItRead) {
  for (const char* every : {"", ", every: 0.05", ", every: 0.01", ", every: step"}) {
    const std::string text = std::string(R"(meltsim: 1
domain: {min: [0, 0, 0], max: [0.6, 0.6, 0.6], walls: box}
particles: {spacing: 0.1}
time: {dt: 0.005, end: 1, fps: 20}
solver: {gravity: [0, 0, 0]}
heat: {time_scale: 100}
materials: {stone: {density: 2000, conductivity: 2.4, heat_capacity: 1000}}
bodies: [{name: slab, fixed: true, material: stone, temperature: 20, heat_source: 2.0e6, shape: {box: [[0,0,0],[0.6,0.6,0.6]]}}]
probes: [{name: mid, at: [0.3, 0.3, 0.3], fields: [temperature])") +
                             every + R"(}]
trade: {observe: [temperature@mid], exact: {temperature@mid: [[0, 20], [1, 120]]}}
)";
    const Tuning tuning(parse(text), cpu(), {}, "");
    const auto made = trade::measure(tuning.problem(), Knobs{}, 60);
    ASSERT_TRUE(made) << made.error().message;
    ASSERT_TRUE(made->complete) << made->problem;
    const trade::Observable& observable = tuning.problem().observables.at(0);
    std::vector<double> expected = observable.exact, values = made->values.at(0);
    ASSERT_EQ(expected.size(), values.size());
    expected.erase(expected.begin());  // before the first step there is none
    values.erase(values.begin());
    EXPECT_LT(trade::difference(observable, 100, values, expected).max, 0.3) << every;
  }
}

TEST(Trade, AnErrorThatCannotBeHadIsRefusedWithOneThatCan) {
  const Tuning tuning(parse(dam), cpu(), {}, "");
  trade::Study study;
  trade::Known known;
  known.observable.name = "front";
  known.observable.unit = "m";
  known.scale = 2;
  known.laws.push_back({Knob::spacing, -4, 0.04, 1, true});
  study.observables.push_back(known);
  study.ranges = trade::default_ranges();
  study.reference_work = study.seconds_per_work = 1;
  const TradeRequest request{0.001, "front", "--max-error 0.1%", true};
  try {
    choose_settings(tuning, study, request);
    FAIL() << "nothing was refused";
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.code(), ExitCode::usage);
    // 0.04 m at the scene's spacing, 0.01 at a quarter of it; of 2 m, with a margin of a half.
    EXPECT_EQ(std::string(failure.what()),
              "--max-error 0.1%: front: the smallest error that this scene can be expected to have is 0.5 % "
              "(0.01 m), with spacing "
              "0.025 m (x 0.25), sound speed " +
                  tuning.settings_text(Knobs{}).substr(
                      std::string("spacing 0.1 m (x 1.00), sound speed ").size(), 4) +
                  " m/s (x 1.00), Courant number 0.4, in about 4.3 min here; ask for 0.75 % or more");
  }
  TradeRequest enough = request;
  enough.max_error = 0.0075;
  EXPECT_NO_THROW(choose_settings(tuning, study, enough));
  study.observables[0].spread = 0.5;
  try {
    choose_settings(tuning, study, enough);
    FAIL() << "chaos was not seen";
  } catch (const Failure& failure) {
    EXPECT_NE(std::string(failure.what()).find("chaotic"), std::string::npos) << failure.what();
  }
}

TEST(Trade, AnErrorThatTurnsOutLargerThanAskedForIsSaid) {
  trade::Known known;
  known.observable.name = "draught@raft";
  known.observable.unit = "m";
  known.scale = 0.15;
  EXPECT_EQ(broken_promise_text(known, 0.0345, 0.0345), "");
  EXPECT_EQ(broken_promise_text(known, 0.039, 0.0345),
            "draught@raft: the estimated error, 26 % (0.039 m), is more than was asked for, 23 % (0.035 m): "
            "between the "
            "probes and these settings it does not follow the law that they gave; give the probes more time "
            "(--time-limit), or ask for less than you need");
}

/// A run of 100 frames at eight spacings, from the coarsest on; a frame takes 1, 2, 4, ... 128 ms by the laws.
std::vector<trade::Choice> doubling_front() {
  std::vector<trade::Choice> front(8);
  for (std::size_t i = 0; i < front.size(); ++i) {
    front[i].knobs[Knob::spacing] = std::pow(2, -0.25 * static_cast<double>(i));
    front[i].seconds = 0.1 * std::pow(2, static_cast<double>(i));
  }
  return front;
}

TEST(Budget, TheMostExactSettingsThatLeaveAFifthFreeAreTaken) {
  int timed = 0;
  const auto as_expected = [&](const Knobs& knobs) {
    ++timed;
    return FrameCost{std::pow(knobs[Knob::spacing], -4), 1};
  };
  for (const auto& [budget, takes] : {std::pair{1000., 128.}, {20.1, 16.}, {19.9, 8.}, {1.3, 1.}}) {
    timed = 0;
    const FitToBudget fit = most_exact_within(budget, 100, doubling_front(), as_expected);
    EXPECT_NEAR(fit.cost.frame_ms, takes, 1e-9) << budget;
    EXPECT_DOUBLE_EQ(fit.choice.seconds, fit.cost.frame_ms / 10) << budget;
    EXPECT_EQ(timed, 1) << budget;
  }
}

TEST(Budget, WhereLawsExpectTooLittleCheaperSettingsAreTimed) {
  std::vector<double> spacings;
  // Three times what the laws say: of 64 ms 16 remain, which take 48.
  const FitToBudget fit = most_exact_within(100, 100, doubling_front(), [&](const Knobs& knobs) {
    spacings.push_back(knobs[Knob::spacing]);
    return FrameCost{3 * std::pow(knobs[Knob::spacing], -4), 1};
  });
  EXPECT_EQ(spacings.size(), 2u);
  EXPECT_NEAR(fit.cost.frame_ms, 48, 1e-9);
  EXPECT_DOUBLE_EQ(fit.choice.knobs[Knob::spacing], spacings.back());
}

TEST(Budget, IsSpentOnAnObservableThatSettingsChange) {
  Tuning tuning(parse(basin), cpu(), {}, "");
  tuning.observe_too("energy");
  tuning.observe_too("melted");  // is there
  const std::vector<std::string> names = names_of(tuning);
  EXPECT_EQ(names, (std::vector<std::string>{"melted", "melt_time_50", "energy"}));
  ASSERT_EQ(tuning.problem().observables.size(), 3u);
  EXPECT_EQ(tuning.problem().observables[2].name, "energy");
  trade::Study study;
  study.observables.resize(3);
  for (std::size_t i = 0; i < 3; ++i) {
    study.observables[i].observable.name = names[i];
    study.observables[i].laws.resize(2);
  }
  EXPECT_EQ(first_that_changes(study).observable.name, "melted");  // none does
  study.observables[2].laws[1].error = 0.1;
  EXPECT_EQ(first_that_changes(study).observable.name, "energy");
  study.observables[0].laws[0].error = 0.1;
  EXPECT_EQ(first_that_changes(study).observable.name, "melted");
}

TEST(Budget, NothingIsTimedForEver) {
  int timed = 0;
  // However coarse, a frame takes 150 ms: launches, say. The coarsest is left at that.
  FitToBudget fit = most_exact_within(100, 100, doubling_front(), [&](const Knobs&) {
    ++timed;
    return FrameCost{150, 1};
  });
  EXPECT_LE(timed, 5);
  EXPECT_DOUBLE_EQ(fit.cost.frame_ms, 150);
  // A budget below all there is: the coarsest, once.
  timed = 0;
  fit = most_exact_within(0.1, 100, doubling_front(), [&](const Knobs& knobs) {
    ++timed;
    return FrameCost{std::pow(knobs[Knob::spacing], -4), 1};
  });
  EXPECT_EQ(timed, 1);
  EXPECT_DOUBLE_EQ(fit.choice.knobs[Knob::spacing], 1);
}

TEST(Trade, AFrontIsDrawnWithoutWhatALogarithmCannotShow) {
  const std::string svg =
      front_svg("a < b", "time [s]", "error",
                {{"front", "#000000", true, {{1, 10}, {10, 1}, {0, 1}, {1, std::nan("")}}}});
  EXPECT_NE(svg.find("a &lt; b"), std::string::npos);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
  EXPECT_NE(svg.find("</svg>"), std::string::npos);
  EXPECT_EQ(front_svg("", "", "", {}).find("nan"), std::string::npos);
}

}  // namespace
}  // namespace runner
