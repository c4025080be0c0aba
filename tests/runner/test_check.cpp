// SPDX-License-Identifier: Apache-2.0
// What `check` finds out ahead of a run: how a trial went, where bodies are carried out of the domain, what mass particles lack, and whether
// explicit heat is stable.
#include <gtest/gtest.h>

#include <cmath>
#include <regex>
#include <string>
#include <vector>

#include "build_world.hpp"
#include "check_paths.hpp"
#include "deep_bodies.hpp"
#include "enclosed_liquid.hpp"
#include "explicit_heat.hpp"
#include "failure.hpp"
#include "load_scene.hpp"
#include "missing_mass.hpp"
#include "rehearsal.hpp"
#include "resolution.hpp"
#include "thin_walls.hpp"

namespace runner {
namespace {

// The blade has 0.6 m to the floor, which its particles reach at t = 0.65 s, half a spacing later than its surface.
const std::string cut = R"(meltsim: 1
domain: {min: [0, 0, 0], max: [1, 1, 1], walls: {x: open}}
particles: {spacing: 0.1}
time: {end: 1, fps: 10}
heat: {time_scale: 1000}
materials:
  water: {viscosity: 0.02}
  ice: {density: 917, melting_point: 0, latent_heat: 3.34e5, becomes: water}
  steel: {density: 7800}
bodies:
  - {name: block, shape: {box: [[0.1,0,0.1],[0.4,0.3,0.4]]}, material: ice, temperature: -5}
  - {name: blade, shape: {box: [[0.6,0.6,0.2],[0.8,0.9,0.5]]}, material: steel, motion: kinematic, velocity: [0,-1,0], max_speed: 1}
)";

MachineOptions cpu() { return {meltsim::Backend::cpu, meltsim::Precision::single_precision, 1, 1}; }

Scene parse(const std::vector<std::string>& set = {}) { return parse_scene(cut, "cut.yaml", "", set); }

/// What is said of the ways of a scene: an error, or warnings.
std::string said_of(const std::vector<std::string>& set) {
  const Scene scene = parse(set);
  Built built = build_world(scene, cpu());
  std::string said;
  try {
    for (const std::string& warning : check_paths(scene, built, scene.time.end))
      said += "warning: " + warning;
  } catch (const Failure& failure) {
    said = failure.what();
  }
  return said;
}

TEST(Rehearsal, SaysThatAndWhyATrialWasRefused) {
  const Scene scene = parse();
  Built built = build_world(scene, cpu());
  const Rehearsal seen = rehearse(scene, built);
  EXPECT_EQ(seen.untried, "");
  EXPECT_NE(seen.stopped.find("was refused at t=0.6"), std::string::npos) << seen.stopped;
  EXPECT_NE(seen.stopped.find("cut.yaml:12:5: bodies[1] (\"blade\"): position: would reach through a wall"),
            std::string::npos)
      << seen.stopped;
  EXPECT_NEAR(seen.until, 0.65, 0.01);
}

TEST(Rehearsal, SaysThatAndWhyATrialDiverged) {
  // What falls ever faster crosses more than its neighbourhood in a step of fixed length.
  const Scene scene = parse({"domain.walls={-y: open}", "solver.gravity=[0, -3000, 0]",
                             "bodies[1].velocity=[0, 0, 0]", "time.end=2"});
  Built built = build_world(scene, cpu());
  const Rehearsal seen = rehearse(scene, built);
  EXPECT_NE(seen.stopped.find("diverged at t="), std::string::npos) << seen.stopped;
  EXPECT_NE(seen.stopped.find(" s: particle "), std::string::npos) << seen.stopped;
}

TEST(Rehearsal, TellsATrialThatCannotBeMadeFromOneThatEnded) {
  const Scene none = parse({"time.end=0"});
  Built built = build_world(none, cpu());
  EXPECT_EQ(rehearse(none, built).untried, "time.end is 0");
  const Scene scene = parse({"bodies[1].velocity=[0, 0, 0]"});
  Built whole = build_world(scene, cpu());
  const Rehearsal seen = rehearse(scene, whole);
  EXPECT_EQ(seen.untried + seen.stopped, "");
  EXPECT_NEAR(seen.until, 1, 1e-6);
}

TEST(Paths, AWayThroughAWallIsRefusedBeforeTheRun) {
  EXPECT_EQ(
      said_of({}),
      "cut.yaml:12:110: bodies[1].velocity: [0, -1, 0] m/s takes \"blade\" through the wall -y at t=0.65 s, "
      "before time.end 1 s: the run would be refused there; use time.end 0.65 or less, a velocity of at most "
      "0.65 of this one, or a domain with more room");
  EXPECT_EQ(said_of({"time.end=0.65"}), "");
  EXPECT_EQ(said_of({"bodies[1].velocity=[0, -0.65, 0]"}), "");
  EXPECT_NE(said_of({"bodies[1].velocity=[0, 0.5, -2]"}).find("through the wall -z at t=0.125 s"),
            std::string::npos);
  EXPECT_EQ(said_of({"bodies[1].velocity=[-1, 0, 0]"}), "");                   // open
  EXPECT_EQ(said_of({"bodies[1].motion=free", "bodies[1].max_speed=0"}), "");  // it comes to rest
}

TEST(Paths, AWayThatMayEndSoonerIsWarnedOf) {
  EXPECT_EQ(said_of({"time.end_when=melted"}).find("warning: cut.yaml:12:110: bodies[1].velocity: "), 0u);
  EXPECT_EQ(said_of({"bodies[1].material=ice"}).find("warning: cut.yaml:12:110: bodies[1].velocity: "), 0u);
}

/// A trial that came to 0.8 s with a tenth of the heat taken up and no whole particle melted yet.
Rehearsal broken_off() {
  Rehearsal seen;
  seen.melting = {{0, 0, 0}, {0.4, 0, 0.05}, {0.8, 0, 0.1}};
  seen.until = 0.8;
  return seen;
}

TEST(Rehearsal, SaysHowFarATrialWentAndWhatOfItIsExtrapolated) {
  const Scene scene = parse({"bodies[1].velocity=[0, 0, 0]"});
  const Built built = build_world(scene, cpu());
  Rehearsal seen = broken_off();
  EXPECT_EQ(melting_text(seen, built, 2, 1),
            "about 25 % of the solid by t=2 s, all of it by about t=8 s; heat.time_scale makes it faster "
            "(extrapolated: tried to t=0.8 s, when 10 % had melted)");
  EXPECT_EQ(melting_text(seen, built, 20, 1),
            "everything melts by about t=8 s (extrapolated: tried to t=0.8 s, when 10 % had melted)");
  seen.changes = true;
  EXPECT_EQ(melting_text(seen, built, 2, 1),
            "10 % of the solid by t=0.8 s (tried to t=0.8 s); beyond that it was not tried, as what heats it "
            "changes in time");
  seen.changes = false;
  seen.melting = {{0, 0, 0}, {0.4, 0, 0.3}, {0.8, 0, 0.1}};
  EXPECT_EQ(melting_text(seen, built, 2, 1),
            "10 % of the solid by t=0.8 s, after 30 % (tried to t=0.8 s); beyond that it was not tried");
  seen.melting = {{0, 0, 0}, {0.4, 0.05, 0.05}, {0.8, 0.1, 0.1}};
  seen.coarseness = 2;
  EXPECT_EQ(
      melting_text(seen, built, 0.8, 1),
      "about 10 % of the solid by t=0.8 s, all of it by about t=8 s (extrapolated); heat.time_scale makes "
      "it faster (tried with particles 2 times as large)");
  seen.melting = {{0, 0, 0}, {0.8, 0, 0.2}};
  EXPECT_EQ(melting_text(seen, built, 0.8, 1),
            "next to nothing is molten through by t=0.8 s, by when 20 % of the heat for it is taken up; "
            "heat.time_scale makes it faster (tried with particles 2 times as large)");
  seen.melting = {{0, 0, 0}, {0.8, 0.01, 0.01}};
  EXPECT_EQ(
      melting_text(seen, built, 2, 1),
      "1 % of the solid by t=0.8 s (tried with particles 2 times as large to t=0.8 s); beyond that it was "
      "not tried");
  seen.melting = {{0, 0, 0}, {0.8, 1, 1}};
  EXPECT_EQ(melting_text(seen, built, 2, 1),
            "everything melts by about t=0.8 s (tried with particles 2 times as large)");
}

TEST(MissingMass, VolumesOfShapesAreKnownToAPercent) {
  constexpr double points = 1e6, pi = 3.14159265358979323846;
  const meltsim::Shape ball = meltsim::Shape::sphere({1, 2, 3}, 0.37),
                       plate = meltsim::Shape::box({0, 0, 0}, {1, 0.0731, 0.9}),
                       cup =
                           meltsim::Shape::subtract(meltsim::Shape::box({0, 0, 0}, {1, 1, 1}),
                                                    meltsim::Shape::box({0.03, 0.03, 0.03}, {0.97, 1, 0.97}));
  for (const int lattices : {5, 13}) {
    EXPECT_NEAR(volume_of(ball, points, lattices) / (4 * pi / 3 * std::pow(0.37, 3)), 1, 0.01);
    EXPECT_NEAR(volume_of(plate, points, lattices) / (0.0731 * 0.9), 1, 0.01);
    // Its walls are 0.03 m thick; lattices of a step of 0.017 or 0.024 m are shifted by a fifth or a 13th of that.
    EXPECT_NEAR(volume_of(cup, points, lattices) / (1 - 0.94 * 0.94 * 0.97), 1, lattices == 5 ? 0.04 : 0.02);
  }
  EXPECT_EQ(volume_of(meltsim::Shape(), points, 13), 0);
}

// The block is three spacings of 0.1 m wide; liquid fills the domain from wall to wall.
const std::string bath = R"(meltsim: 1
domain: {min: [0, 0, 0], max: [0.8, 1.2, 0.8], walls: box}
particles: {spacing: 0.1}
time: {end: 0.5, fps: 10}
heat: {model: enthalpy, time_scale: 1e5}
materials:
  water: {density: 1000, viscosity: 0.1}
  ice: {density: 917, conductivity: 2.2, heat_capacity: 2100, melting_point: 0, latent_heat: 3.34e5, becomes: water}
fluids:
  - {shape: {box: [[0,0,0],[0.8,0.4,0.8]]}, material: water, temperature: 40}
  - {shape: {box: [[0,0.2,0],[0.8,0.5,0.8]]}, material: water, temperature: 50}
bodies:
  - {name: block, material: ice, temperature: -10, shape: {box: [[0.2,0.6,0.2],[0.5,0.9,0.5]]}}
output: {export: []}
)";

std::vector<std::string> missing_at(const std::vector<std::string>& set) {
  const Scene scene = parse_scene(bath, "bath.yaml", "", set);
  Built built = build_world(scene, cpu());
  return missing_mass(scene, built);
}

TEST(MissingMass, IsNamedWithTheSpacingThatFits) {
  const std::string one = "fluids=[{shape: {box: [[0,0,0],[0.8,0.4,0.8]]}, material: water}]";
  EXPECT_EQ(missing_at({}), std::vector<std::string>{});  // nor does liquid that was there already count
  const std::vector<std::string> warnings = missing_at({one, "particles.spacing=0.13"});
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(
      warnings[0],
      "bath.yaml:13:5: bodies[0].shape: the particles of \"block\" have 16.1 kg, 35 % less than its volume "
      "times density, about 25 kg: particles.spacing 0.13 does not fit it; use particles.spacing 0.1, which "
      "fits every body and liquid");
  EXPECT_EQ(missing_at({one, "particles.spacing=0.1"}), std::vector<std::string>{});
  Scene scaled = parse_scene(bath, "bath.yaml", "", {one});
  apply_spacing(scaled, 0.13);
  Built built = build_world(scaled, cpu());
  const std::string scale =
      "use particles.spacing 0.1 and no --scale or --quality, which fits every body and liquid";
  EXPECT_NE(missing_mass(scaled, built).at(0).find(scale), std::string::npos);
}

TEST(MissingMass, IsThatOfLiquidsToo) {
  const std::string ice = "bodies=[]",
                    flat = "fluids=[{shape: {box: [[0,0,0],[0.8,0.26,0.8]]}, material: water}]";
  const std::vector<std::string> warnings = missing_at({ice, flat, "particles.spacing=0.1"});
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_NE(warnings[0].find("have 192 kg, 15 % more than its volume times density, about 16"),
            std::string::npos)
      << warnings[0];
  const std::regex advised("use particles.spacing (\\S+), which");
  std::smatch match;
  ASSERT_TRUE(std::regex_search(warnings[0], match, advised)) << warnings[0];
  EXPECT_EQ(missing_at({ice, flat, "particles.spacing=" + match[1].str()}), std::vector<std::string>{});
}

constexpr const char* well = R"(meltsim: 1
domain: {min: [0,0,0], max: [1.6,3.4,1.6]}
particles: {spacing: 0.1}
time: {end: 1}
materials:
  water: {density: 1000}
  ice: {density: 917}
fluids:
  - {shape: {box: [[0,0,0],[1.6,2.8,1.6]]}, material: water}
bodies:
  - {name: ball, material: ice, shape: {sphere: {center: [0.8,0.6,0.8], radius: 0.3}}}
output: {export: []}
)";

// Depths, densities and motions on both sides of what is warned of; along another axis; and what is advised ends it.
TEST(DeepBodies, AreNamedWithTheFieldThatCuresThem) {
  const auto at = [](const std::vector<std::string>& set) {
    return deep_bodies(parse_scene(well, "well.yaml", "", set));
  };
  const std::string field = "force_fields=[{kind: hydrostatic, center: [0.8, 2.3, 0.8], density: 1000}]";
  const std::vector<std::string> warnings = at({});
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(
      warnings[0],
      "well.yaml:11:5: bodies[0]: \"ball\", of 0.917 times the density of the liquid, lies 19 spacings "
      "deep: the pressure there holds it back, by a quarter or more of its way. Where all below a level "
      "stays full of liquid, this cures it: force_fields: [{kind: hydrostatic, center: [0.8, 2.3, 0.8], "
      "density: 1000}]");
  for (const char* usual :
       {"materials.ice.density=500", "materials.ice.density=1300", "bodies[0].motion=fixed",
        "bodies[0].shape.sphere.center=[0.8,1.5,0.8]", "solver.gravity=[0,0,0]",
        "bodies[0].shape.sphere.center=[0.8,3,0.8]", field.c_str()})
    EXPECT_EQ(at({usual}), std::vector<std::string>{}) << usual;
  const std::vector<std::string> turned =
      at({"solver.gravity=[9.81,0,0]", "domain.max=[3.4,1.6,1.6]", "materials.ice.density=1100",
          "fluids[0].shape.box=[[0.6,0,0],[3.4,1.6,1.6]]", "bodies[0].shape.sphere.center=[2.8,0.8,0.8]"});
  ASSERT_EQ(turned.size(), 1u);
  EXPECT_NE(turned[0].find("of 1.1 times the density of the liquid, lies 19 spacings deep"),
            std::string::npos)
      << turned[0];
  EXPECT_NE(turned[0].find("center: [1.1, 0.8, 0.8]"), std::string::npos) << turned[0];
}

// A cup of water, 10 spacings in radius; its wall and floor are as thick as `wall`.
std::string cup(double wall) {
  const auto number = [](double x) { return std::to_string(x); };
  const std::string inner = "{cylinder: {from: [1, 0.4, 1], to: [1, 1.1, 1], radius: 0.5}}",
                    outer = "{cylinder: {from: [1, " + number(0.4 - wall) +
                            ", 1], to: [1, 1, 1], radius: " + number(0.5 + wall) + "}}";
  return R"(meltsim: 1
domain: {min: [0, 0, 0], max: [2, 1.2, 2]}
particles: {spacing: 0.05}
materials: {water: {}, steel: {density: 7800}}
fluids: [{material: water, shape: {cylinder: {from: [1, 0.4, 1], to: [1, 0.8, 1], radius: 0.5}}}]
bodies: [{name: cup, material: steel, fixed: true, shape: {difference: [)" +
         outer + ", " + inner + "]}}]\n";
}

std::vector<std::string> thin_of(const std::string& text, const std::vector<std::string>& set = {}) {
  const Scene scene = parse_scene(text, "cup.yaml", "", set);
  Built built = build_world(scene, cpu());
  return thin_walls(scene, built);
}

// Of a wall of one spacing 359 of 2528 particles leaked in a second, of 1.5 and 2 none.
TEST(ThinWalls, AreNamedWhereTheyAreCurvedAndHoldLiquid) {
  const std::vector<std::string> said = thin_of(cup(0.05));
  ASSERT_EQ(said.size(), 1u);
  EXPECT_TRUE(std::regex_match(
      said[0],
      std::regex("cup.yaml:6:10: bodies\\[0\\].shape: [0-9]+ % of the sites of \"cup\" are one thick, in "
                 "walls that are curved or turned against the lattice: liquid leaks through; make its "
                 "walls 1.5 to 2 spacings thick \\(0.1 m or more\\), or use a particles.spacing of 0.025 "
                 "or less")))
      << said[0];
  EXPECT_EQ(thin_of(cup(0.075)), std::vector<std::string>{});
  EXPECT_EQ(thin_of(cup(0.1)), std::vector<std::string>{});
  EXPECT_EQ(thin_of(cup(0.05), {"fluids=[]"}), std::vector<std::string>{});
  EXPECT_EQ(thin_of(cup(0.05), {"fluids[0].shape={box: [[0, 0, 0], [0.2, 0.2, 0.2]]}"}),
            std::vector<std::string>{});
}

// A tray of one spacing along the lattice does not leak at rest; turned by 15 degrees 12 of 866 particles leaked.
TEST(ThinWalls, AreNamedWhereFlatOnesAreTurned) {
  const auto tray = [](const std::string& turn) {
    return "bodies[0].shape={difference: [{box: [[0.45, 0.35, 0.45], [1.55, 0.8, 1.55]]}, {box: [[0.5, 0.4, "
           "0.5], "
           "[1.5, 1, 1.5]]}]" +
           turn + "}";
  };
  const std::string water = "fluids[0].shape={box: [[0.6, 0.5, 0.6], [1.4, 0.6, 1.4]]}";
  EXPECT_EQ(thin_of(cup(0.05), {tray(""), water}), std::vector<std::string>{});
  const std::string turn = ", transform: {axis: [0, 0, 1], angle: 15, offset: [0.2, -0.2, 0]}";
  EXPECT_EQ(thin_of(cup(0.05), {tray(turn), water}).size(), 1u);
}

// A hollow ball in a tank: the liquid's box covers its cavity as well.
TEST(EnclosedLiquid, IsNamedWhereItLiesOutsideToo) {
  const std::string hollow = R"(meltsim: 1
domain: {min: [0, 0, 0], max: [2, 2, 2]}
particles: {spacing: 0.1}
materials: {water: {}, steel: {density: 1000}}
fluids: [{material: water, shape: {box: [[0, 0, 0], [2, 1.8, 2]]}}]
bodies: [{name: buoy, material: steel, motion: rigid, shape: {difference: [{sphere: {center: [1, 0.9, 1], radius: 0.7}}, {sphere: {center: [1, 0.9, 1], radius: 0.45}}]}}]
)";
  const auto said = [&hollow](const std::vector<std::string>& set) {
    const Scene scene = parse_scene(hollow, "hollow.yaml", "", set);
    Built built = build_world(scene, cpu());
    return enclosed_liquid(scene, built);
  };
  const std::vector<std::string> warnings = said({});
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_TRUE(std::regex_match(
      warnings[0],
      std::regex("hollow.yaml:5:10: fluids\\[0\\]: [34][0-9][0-9] of its particles are enclosed in body "
                 "\"buoy\": its shape covers the cavity too; if there is to be air, subtract the "
                 "body's outer shape from it \\(difference\\)")))
      << warnings[0];
  // Air in the cavity; a vessel that only holds what was put into it; a hole in the wall.
  EXPECT_EQ(
      said({"fluids[0].shape={difference: [{box: [[0, 0, 0], [2, 1.8, 2]]}, {sphere: {center: [1, 0.9, 1], "
            "radius: 0.7}}]}"}),
      std::vector<std::string>{});
  EXPECT_EQ(said({"fluids[0].shape={sphere: {center: [1, 0.9, 1], radius: 0.5}}"}),
            std::vector<std::string>{});
  EXPECT_EQ(
      said({"bodies[0].shape.difference[1]={cylinder: {from: [1, 0.9, 1], to: [1, 2, 1], radius: 0.3}}"}),
      std::vector<std::string>{});
}

// A trial with larger particles keeps periodic axes three support radii long.
TEST(Rehearsal, OfAPeriodicColumnIsTried) {
  const Scene scene = parse_scene(R"(meltsim: 1
domain: {min: [0, 0, 0], max: [0.4, 1.2, 0.4], walls: {x: periodic, z: periodic}}
particles: {spacing: 0.05}
time: {end: 20, fps: 2}
heat: {time_scale: 1000}
materials:
  water: {viscosity: 0.02}
  ice: {density: 917, melting_point: 0, latent_heat: 3.34e5, becomes: water}
fluids: [{material: water, temperature: 40, shape: {box: [[0, 0, 0], [0.4, 0.8, 0.4]]}}]
bodies: [{material: ice, temperature: -5, fixed: true, shape: {box: [[0, 0.8, 0], [0.4, 1, 0.4]]}}]
)",
                                  "column.yaml", "", {});
  Built built = build_world(scene, cpu());
  const Rehearsal seen = rehearse(scene, built);
  EXPECT_EQ(seen.untried, "");
  EXPECT_GT(seen.until, 0);
}

TEST(Paths, LiquidWithNothingBelowItThatFallsOutIsWarnedOf) {
  const std::string rain = R"(meltsim: 1
domain: {min: [0, 0, 0], max: [1, 1, 1], walls: {-y: open}}
particles: {spacing: 0.1}
time: {end: 2}
materials: {water: {}, steel: {density: 7800}}
fluids: [{material: water, shape: {box: [[0.2, 0.4, 0.2], [0.8, 0.8, 0.8]]}}]
)";
  const auto said = [&rain](const std::vector<std::string>& set) {
    const Scene scene = parse_scene(rain, "rain.yaml", "", set);
    Built built = build_world(scene, cpu());
    return check_paths(scene, built, scene.time.end);
  };
  const std::vector<std::string> warnings = said({});
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0],
            "rain.yaml:2:9: domain.walls: gravity points out of the open face -y and nothing is below the "
            "liquid: all "
            "of it falls out of the domain by t=0.4 s, before time.end 2 s; close the face (domain.walls: "
            "{-y: wall}), "
            "put a fixed body as a floor below it, or turn solver.gravity");
  for (const char* set :
       {"domain.walls={+y: open}", "time.end=0.3", "solver.gravity=[0, 9.81, 0]",
        "bodies=[{material: steel, fixed: true, shape: {box: [[0, 0, 0], [0.6, 0.2, 0.6]]}}]"})
    EXPECT_EQ(said({set}), std::vector<std::string>{}) << set;
}

TEST(ExplicitHeat, IsWarnedOfBeyondItsStableStep) {
  const Scene other = parse_scene(bath, "bath.yaml", "", {});
  const Scene scene = parse_scene(bath, "bath.yaml", "", {"heat.model=iwasaki", "heat.time_scale=1e8"});
  Built built = build_world(scene, cpu()), enthalpy = build_world(other, cpu());
  EXPECT_TRUE(std::isinf(explicit_heat_dt(other, enthalpy.world)));
  EXPECT_EQ(explicit_heat_cure(other, enthalpy.world), "");
  const double stable = explicit_heat_dt(scene, built.world);
  EXPECT_EQ(explicit_heat_warning(scene, built.world, 0.99 * stable), "");
  EXPECT_NE(explicit_heat_warning(scene, built.world, 1.01 * stable).find("heat.model: iwasaki in steps of "),
            std::string::npos);
  // The flag of the library is up beyond it.
  for (const double share : {0.95, 1.05}) {
    Built run = build_world(scene, cpu());
    ASSERT_TRUE(run.world.step(share * stable));
    EXPECT_EQ(run.world.synchronize().heat_bound_exceeded, share > 1) << share;
  }
}

}  // namespace
}  // namespace runner
