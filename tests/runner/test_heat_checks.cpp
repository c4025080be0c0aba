// SPDX-License-Identifier: Apache-2.0
// What is said of heat and freezing ahead of a run and at its end: seeds that melt away, surfaces that insulate, what regions release,
// what freezes; and of bodies that fall out or turn into a wall.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "build_world.hpp"
#include "check_heat.hpp"
#include "check_paths.hpp"
#include "failure.hpp"
#include "freezing.hpp"
#include "halt.hpp"
#include "heat_balance.hpp"
#include "heat_regions.hpp"
#include "load_scene.hpp"
#include "rehearsal.hpp"
#include "room_to_melt.hpp"
#include "saturation.hpp"
#include "thin_layers.hpp"

namespace runner {
namespace {

MachineOptions cpu_of_one() { return {meltsim::Backend::cpu, meltsim::Precision::single_precision, 1, 1}; }

// A chill layer of one spacing beside superheated melt, opposite to a wall that cools.
const std::string chill = R"(meltsim: 1
domain: {min: [0, 0, 0], max: [0.06, 0.06, 0.06]}
particles: {spacing: 0.01}
solver: {gravity: [0, 0, 0], sound_speed: 2}
time: {end: 1.2, fps: 5}
heat: {time_scale: 200, walls: {+x: {convection: 5000, ambient: 20}}}
materials:
  al: {density: 2400, conductivity: 100, heat_capacity: 1080}
  als: {density: 2400, conductivity: 200, heat_capacity: 1080, melting_point: 660, latent_heat: 3.9e5, becomes: al, freezes: true}
bodies: [{name: seed, material: als, fixed: true, temperature: 640, growth: 6, shape: {box: [[0, 0, 0], [0.01, 0.06, 0.06]]}}]
fluids: [{material: al, temperature: 1300, shape: {box: [[0.01, 0, 0], [0.06, 0.06, 0.06]]}}]
)";

const std::string none_left =
    "\"al\" freezes onto bodies of \"als\", and in a trial the last of them melted away: from then on it "
    "stays liquid however cold it is; keep some of it solid: ";

/// What check says of seeds that melt away.
std::vector<std::string> said_of_seed(const std::vector<std::string>& set) {
  const Scene scene = parse_scene(chill, "chill.yaml", "", set);
  Built built = build_world(scene, cpu_of_one());
  return will_not_freeze(scene, rehearse(scene, built).gone, false, "in a trial");
}

TEST(Freezing, ASeedThatMeltsAwayIsWarnedOfAhead) {
  const std::vector<std::string> said = said_of_seed({});
  ASSERT_EQ(said.size(), 1u);
  EXPECT_EQ(said[0].find(none_left), 0u) << said[0];
  EXPECT_EQ(said_of_seed({"fluids[0].temperature=665"}), std::vector<std::string>{});  // the seed stays
  // Nothing cools below 660 C, so that nothing would freeze anyhow; a region, an emitter or the air may.
  const std::string warm = "heat={time_scale: 200, walls: {+x: {convection: 5000, ambient: 700}}}";
  EXPECT_EQ(said_of_seed({warm}), std::vector<std::string>{});
  EXPECT_EQ(said_of_seed({"heat={time_scale: 200, free_surface: {emissivity: 0.3}}"}).size(), 1u);
  EXPECT_EQ(said_of_seed({"heat={time_scale: 200, regions: [{shape: {box: [[0.05,0,0],[0.06,0.06,0.06]]}, "
                          "source: -1e5}]}"})
                .size(),
            1u);
  EXPECT_EQ(said_of_seed({"materials.als.freezes=false", "bodies[0].growth=0"}), std::vector<std::string>{});
}

TEST(Freezing, LiquidWithNothingToFreezeOntoIsWarnedOf) {
  const auto said = [](const std::vector<std::string>& set) {
    return nothing_to_freeze_onto(parse_scene(chill, "chill.yaml", "", set));
  };
  EXPECT_EQ(said({}), std::vector<std::string>{});
  const std::vector<std::string> warnings = said({"bodies=[]"});
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0],
            "\"al\" freezes onto bodies of \"als\", and there is none: it stays liquid however cold it is; "
            "add one, with `growth`");
}

TEST(Freezing, LiquidThatEndsBelowItsMeltingPointIsSaidAtTheEnd) {
  const Scene scene = parse_scene(chill, "chill.yaml", "", {});
  Built built = build_world(scene, cpu_of_one());
  EXPECT_EQ(left_supercooled(scene, built), std::vector<std::string>{});  // the seed is there
  for (int i = 0; i < 8; ++i) ASSERT_TRUE(built.world.step(0.005));
  EXPECT_EQ(melted_away(scene, built), std::vector<std::string>{"als"});
  EXPECT_EQ(left_supercooled(scene, built), std::vector<std::string>{});  // still hot
  for (int i = 0; i < 200; ++i) ASSERT_TRUE(built.world.step(0.005));
  const std::vector<std::string> said = left_supercooled(scene, built);
  ASSERT_EQ(said.size(), 1u);
  EXPECT_EQ(
      said[0].find("216 of 216 particles of \"al\" ended liquid below 660 C, where \"als\" melts: there is "
                   "no body of \"als\" left that they could freeze onto; "),
      0u)
      << said[0];
}

/// The warnings of a scene as it is read.
std::string read_with(const std::vector<std::string>& set) {
  std::string said;
  for (const std::string& warning : parse_scene(chill, "chill.yaml", "", set).warnings)
    said += warning + "\n";
  return said;
}

TEST(HeatChecks, WhatFreezesUnderTheAirNeedsASurfaceOfItsOwn) {
  const std::string air = "heat={free_surface: {convection: 500, ambient: 20}}";
  EXPECT_EQ(read_with({}), "");
  EXPECT_EQ(read_with({air}),
            "chill.yaml:10:10: bodies[0].surface: none: heat.free_surface is of liquid alone, and what has "
            "frozen onto \"seed\" exchanges no heat with the air; give the body the same, surface: "
            "{convection: 500, ambient: 20}\n");
  EXPECT_EQ(read_with({air, "bodies[0].surface={convection: 500, ambient: 20}"}), "");
  EXPECT_EQ(read_with({air, "bodies[0].growth=0"}), "");
  EXPECT_EQ(read_with({air, "materials.als.freezes=false"}), "");
}

TEST(HeatChecks, AnAmbientAloneMovesNoHeat) {
  EXPECT_EQ(read_with({"bodies[0].surface={ambient: 25}"}),
            "--set bodies[0].surface={ambient: 25}: bodies[0].surface.ambient: 25 C alone moves no heat, so "
            "this surface insulates: add convection [W/(m^2 K)] or emissivity beside it, e.g. convection: 10 "
            "in still air, or leave it out\n");
  EXPECT_NE(read_with({"heat={walls: {-y: {ambient: 20}}}"}).find("heat.walls.-y.ambient: 20 C alone"),
            std::string::npos);
  EXPECT_NE(read_with({"heat={free_surface: {ambient: 20}}"}).find("heat.free_surface.ambient: 20 C alone"),
            std::string::npos);
  EXPECT_EQ(read_with({"bodies[0].surface={flux: 10, ambient: 25}"}).find("so this surface"),
            std::string::npos);
  EXPECT_EQ(read_with({"bodies[0].surface={emissivity: 0.5, ambient: 25}"}), "");
  EXPECT_EQ(read_with({"bodies[0].surface={convection: 0, ambient: 25}"}), "");  // as one of a series
}

// What melts under a flux and stays covers the body, and the flux stops: a plate of steel took 19 J of 40. Where gravity takes melt away air and
// held temperatures go on; without gravity they stop likewise.
TEST(HeatChecks, AFluxThatItsOwnMeltStopsIsWarnedOf) {
  const std::string seed = "bodies[0].growth=0", grows = "materials.als.freezes=false",
                    down = "solver={gravity: [0, -9.81, 0]}", flux = "bodies[0].surface={flux: 1e6}",
                    air = "bodies[0].surface={convection: 50, ambient: 900}";
  EXPECT_EQ(read_with({seed, grows, flux}),
            "chill.yaml:10:10: bodies[0].surface: is of what is dry of \"seed\": what has melted and stays "
            "on it covers it, and there no "
            "heat comes in any more; for heat that goes on through the melt add heat.free_surface: {flux: "
            "1e+06}\n");
  EXPECT_NE(read_with({seed, grows, flux, down}), "");
  EXPECT_NE(read_with({seed, grows, air}), "");
  EXPECT_EQ(read_with({seed, grows, air, down}), "");
  EXPECT_EQ(read_with({seed, grows, "bodies[0].surface={flux: -1e6}"}), "");
  EXPECT_EQ(read_with({seed, grows, "bodies[0].surface={convection: 50, ambient: 300}"}), "");
  EXPECT_EQ(read_with({seed, grows, flux, "heat.free_surface={flux: 1e6}"}), "");
  EXPECT_EQ(read_with({seed, grows, flux, "bodies[0].material=al"}), "");
}

// A sheet between two bars. Of one spacing it passes 2.6 times as much as it should at this ratio of conductivities, of two what it should.
TEST(HeatChecks, AThinLayerBetweenBetterConductorsIsWarnedOf) {
  const std::string bars = R"(meltsim: 1
domain: {min: [0, 0, 0], max: [0.08, 0.13, 0.08], walls: {x: periodic, z: periodic}}
particles: {spacing: 0.01}
solver: {gravity: [0, 0, 0], sound_speed: 2}
materials: {cu: {density: 5000, heat_capacity: 500, conductivity: 400}, paper: {density: 5000, heat_capacity: 500, conductivity: 4}}
bodies:
  - {material: cu, fixed: true, shape: {box: [[0, 0, 0], [0.08, 0.06, 0.08]]}}
  - {name: sheet, material: paper, fixed: true, shape: {box: [[0, 0.06, 0], [0.08, 0.07, 0.08]]}}
  - {material: cu, fixed: true, shape: {box: [[0, 0.07, 0], [0.08, 0.13, 0.08]]}}
)";
  const auto said = [&bars](const std::vector<std::string>& set) {
    const Scene scene = parse_scene(bars, "bars.yaml", "", set);
    Built built = build_world(scene, cpu_of_one());
    return thin_layers(scene, built);
  };
  const std::vector<std::string> warnings = said({});
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0],
            "bars.yaml:8:5: bodies[1].shape: \"sheet\" is one spacing thick between bodies that conduct "
            "100 times as well: these reach each "
            "other across it, so that more heat passes than it would let through, 2.6 times as much at a "
            "ratio of 100, 19 times at 1000; make "
            "it two spacings thick (0.02 m), with twice its conductivity where its resistance is to stay");
  const auto none = std::vector<std::string>{};
  EXPECT_EQ(said({"bodies[1].shape={box: [[0, 0.06, 0], [0.08, 0.08, 0.08]]}",
                  "bodies[2].shape={box: [[0, 0.08, 0], [0.08, 0.13, 0.08]]}"}),
            none);
  EXPECT_EQ(said({"materials.paper.conductivity=200"}), none);
  EXPECT_EQ(said({"bodies[2].shape={box: [[0, 0.09, 0], [0.08, 0.13, 0.08]]}"}),
            none);  // nothing on its other side
  EXPECT_EQ(said({"heat.time_scale=0"}), none);
}

// A closed box that is full of wax, which takes up a tenth more as liquid; 3.8e-5 of 3.84e-4 m^3.
const std::string full = R"(meltsim: 1
domain: {min: [0, 0, 0], max: [0.08, 0.06, 0.08], walls: box}
particles: {spacing: 0.01}
heat: {time_scale: 100, walls: {-x: {temperature: 60}}}
materials:
  oil: {density: 800}
  wax: {density: 880, melting_point: 28, latent_heat: 2e5, becomes: oil}
bodies: [{material: wax, fixed: true, temperature: 18, shape: {box: [[0, 0, 0], [0.08, 0.06, 0.08]]}}]
)";

TEST(RoomToMelt, AClosedBoxThatIsFullIsWarnedOf) {
  const auto said = [](const std::vector<std::string>& set) {
    const Scene scene = parse_scene(full, "full.yaml", "", set);
    Built built = build_world(scene, cpu_of_one());
    return room_to_melt(scene, built);
  };
  const std::vector<std::string> warnings = said({}), none;
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].find("full.yaml:8:10: bodies[0].material: what melts takes up 3.8e-05 m^3 more as "
                             "liquid than as solid, and the "
                             "closed domain has 0 m^3 free: the liquid is compressed by 10.0 %"),
            0u)
      << warnings[0];
  EXPECT_EQ(said({"domain.walls={+y: open}"}), none);
  EXPECT_EQ(said({"materials.oil.density=880"}), none);
  EXPECT_EQ(said({"materials.wax.density=700"}), none);
  EXPECT_EQ(said({"bodies[0].shape={box: [[0, 0, 0], [0.08, 0.05, 0.08]]}"}), none);
  EXPECT_EQ(said({"fluids=[{material: oil, shape: {box: [[0, 0.05, 0], [0.08, 0.06, 0.08]]}}]",
                  "bodies[0].shape={box: [[0, 0, 0], [0.08, 0.05, 0.08]]}"})
                .size(),
            1u);
}

TEST(Convection, UnderATimeLapseIsWarnedOf) {
  const auto said = [](const std::vector<std::string>& set) {
    return parse_scene(full, "full.yaml", "", set).warnings;
  };
  const std::string table = "materials.oil={density: [[20, 800], [60, 775]]}";
  EXPECT_EQ(said({}), std::vector<std::string>{});
  const std::vector<std::string> warnings = said({table});
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].find("full.yaml:4:20: heat.time_scale: heat is 100 times as fast as motion, so "
                             "liquid that rises and sinks by the "
                             "density table of \"oil\" carries next to none of it"),
            0u)
      << warnings[0];
  EXPECT_EQ(said({table, "heat.time_scale=1"}), std::vector<std::string>{});
  EXPECT_EQ(said({table, "solver.gravity=[0, 0, 0]"}), std::vector<std::string>{});
  EXPECT_EQ(said({"materials.oil={density: [[20, 800], [60, 800]]}"}), std::vector<std::string>{});
}

// Half of the ball is in the plate; its eight cells have 8e-9 m^3, the ball has 4/3 pi 1e-9.
const std::string laser = R"(meltsim: 1
domain: {min: [0, 0, 0], max: [0.012, 0.008, 0.012], walls: {+y: open}}
particles: {spacing: 0.001}
time: {end: 0.02, fps: 100}
heat: {regions: [{name: laser, shape: {sphere: {center: [0.006, 0.006, 0.006], radius: 0.001}}, source: 1e9}]}
materials: {s: {density: 7000, conductivity: 30, heat_capacity: 700}}
bodies: [{material: s, fixed: true, shape: {box: [[0, 0, 0], [0.012, 0.006, 0.012]]}}]
)";

Scene with_laser(const std::vector<std::string>& set) { return parse_scene(laser, "laser.yaml", "", set); }

/// [W] What a run of one step says that came in.
double power_of(const Scene& scene, Built& built) {
  const double dt = 0.001;
  EXPECT_TRUE(built.world.step(dt));
  meltsim::ReadRequest request;
  request.totals = true;
  const double in = built.world.take(*built.world.request(request))->totals.heat_in;
  return in / dt / scene.world.heat.time_scale;
}

TEST(HeatRegions, ReleaseWhatTheParticlesInThemGet) {
  for (const char* shape :
       {"sphere: {center: [0.006, 0.006, 0.006], radius: 0.001}",
        "sphere: {center: [0.0062, 0.0057, 0.006], radius: 0.0018}",
        "box: [[0.004, 0.0045, 0.004], [0.0084, 0.006, 0.008]]", "box: [[-1, -1, -1], [1, 1, 0.0033]]"}) {
    const Scene scene = with_laser({std::string("heat.regions[0].shape={") + shape + "}"});
    Built built = build_world(scene, cpu_of_one());
    const std::vector<RegionPower> powers = region_powers(scene, built);
    ASSERT_EQ(powers.size(), 1u);
    EXPECT_NEAR(powers[0].power, 1e9 * 1e-9 * static_cast<double>(powers[0].particles), 1e-4) << shape;
    EXPECT_NEAR(power_of(scene, built) / powers[0].power, 1, 1e-3) << shape;
  }
}

// A region with nothing in it brings no heat; one that cools says so.
TEST(HeatRegions, ThatHeatNothingAreNoSources) {
  const Scene scene = with_laser({});
  EXPECT_EQ(heat_sources_text(scene), "region \"laser\"");
  EXPECT_EQ(heat_sources_text(scene, {"laser"}), "");
  EXPECT_EQ(heat_sources_text(with_laser({"heat.regions[0].source=-1e9"})), "region \"laser\" (cools)");
}

// Values in time count with the whole of their span, and are written as lists.
TEST(HeatInTime, IsReadAndCountedAsASpan) {
  const Scene scene =
      with_laser({"heat.regions=[]", "heat.walls={-y: {temperature: [[0, 20], [1, 1700], [2, 20]]}}",
                  "heat.free_surface={flux: [[0, -5], [3, 7]]}"});
  const meltsim::SurfaceHeatDesc& wall = scene.world.domain.heat[2];
  ASSERT_EQ(wall.temperature_points.size(), 3u);
  EXPECT_EQ(wall.temperature, 20);
  EXPECT_EQ(temperatures_of(wall).most, 1700);
  EXPECT_EQ(temperatures_of(wall).least, 20);
  EXPECT_EQ(fluxes_of(scene.world.heat.free_surface).least, -5);
  EXPECT_TRUE(acts(scene.world.heat.free_surface));
  EXPECT_EQ(scene.world.heat.free_surface.flux, 0);
  Built built = build_world(scene, cpu_of_one());
  EXPECT_TRUE(rehearse(scene, built).changes);
  // An ambient that nothing exchanges heat with is an oversight, whatever it is in time.
  const Scene idle = with_laser({"bodies[0].surface={ambient: [[0, 20], [1, 60]]}"});
  EXPECT_NE(idle.warnings.back().find("surface.ambient: alone moves no heat"), std::string::npos)
      << idle.warnings.back();
}

// One that moves is counted where it is when it begins to act, and one that comes from elsewhere is a source.
TEST(HeatRegions, OnAPathReleaseWhatTheParticlesOnItGet) {
  const std::string cube = "heat.regions[0].shape={box: [[0.004, 0.004, 0.004], [0.006, 0.006, 0.006]]}";
  const Scene scene = with_laser({cube, "heat.regions[0].path=[[0, 0.002, 0, 0], [1, 0.003, 0, 0]]"});
  ASSERT_EQ(scene.heat_regions[0].desc.path.size(), 2u);
  Built built = build_world(scene, cpu_of_one());
  const std::vector<RegionPower> powers = region_powers(scene, built);
  ASSERT_EQ(powers.size(), 1u);
  EXPECT_GT(powers[0].particles, 0u);
  EXPECT_NEAR(power_of(scene, built) / powers[0].power, 1, 1e-3);
  EXPECT_THROW(with_laser({cube, "heat.regions[0].path=[[0, 0, 0]]"}), Failure);
  EXPECT_THROW(with_laser({cube, "heat.regions[0].path=[[1, 0, 0, 0], [1, 0, 0, 0]]"}), Failure);
}

TEST(HeatRegions, OfOtherVolumesThanTheirShapesAreWarnedOf) {
  const std::vector<std::string> said = uneven_regions(with_laser({}));
  ASSERT_EQ(said.size(), 1u);
  EXPECT_EQ(
      said[0].find("laser.yaml:5:105: heat.regions[0].source: \"laser\" heats particles whose centres are "
                   "in it: at particles.spacing 0.001 those of 8 cells, 8e-09 m^3, 91 % more than its "
                   "shape has, 4.19e-09 m^3, and so is its power; use source: 5.2"),
      0u)
      << said[0];
  const auto none = std::vector<std::string>{};
  EXPECT_EQ(
      uneven_regions(with_laser({"heat.regions[0].shape={box: [[0.004,0.003,0.004],[0.008,0.006,0.008]]}"})),
      none);
  EXPECT_EQ(uneven_regions(with_laser({"heat.regions[0].shape={box: [[-9,-9,-9],[9,9,9]]}"})), none);
  EXPECT_EQ(uneven_regions(with_laser({"heat.regions[0]={shape: {sphere: {center: [0.006, 0.006, 0.006], "
                                       "radius: 0.001}}, temperature: 900}"})),
            none);
}

const std::string slug = R"(meltsim: 1
domain: {min: [0, 0, 0], max: [0.1, 0.1, 0.1], walls: {-y: open, +y: open}}
particles: {spacing: 0.01}
time: {end: 10, fps: 2}
heat: {model: none}
materials: {wax: {density: 900}}
bodies: [{name: slug, material: wax, shape: {box: [[0.03, 0.03, 0.03], [0.07, 0.07, 0.07]]}}]
)";

/// What is said of the ways of a scene: an error, or warnings.
std::string ways_of(const std::string& text, const std::vector<std::string>& set) {
  const Scene scene = parse_scene(text, "way.yaml", "", set);
  Built built = build_world(scene, cpu_of_one());
  std::string said;
  try {
    for (const std::string& warning : check_paths(scene, built, scene.time.end))
      said += "warning: " + warning;
  } catch (const Failure& failure) {
    said = failure.what();
  }
  return said;
}

TEST(Paths, ABodyThatFallsOutIsWarnedOf) {
  // Its top has 0.07 m to go: sqrt(2 * 0.07 / 9.81) s.
  EXPECT_EQ(ways_of(slug, {}),
            "warning: way.yaml:7:10: bodies[0]: \"slug\" falls out of the domain through its open face -y by "
            "t=0.12 s, before time.end 10 s: only liquid is removed there, and a run ends when a body is too "
            "fast; close the face (domain.walls: {-y: wall}), put a fixed body as a floor below it, or use "
            "time.end 0.11 or less");
  const std::string floor =
      ", {material: wax, fixed: true, shape: {box: [[0.03, 0, 0.03], [0.05, 0.01, 0.05]]}}]";
  const std::string body = "bodies=[{material: wax, shape: {box: [[0.03, 0.03, 0.03], [0.07, 0.07, 0.07]]}}";
  EXPECT_EQ(ways_of(slug, {body + floor}), "");
  EXPECT_EQ(ways_of(slug, {"domain.walls={+y: open}"}), "");
  EXPECT_EQ(ways_of(slug, {"time.end=0.1"}), "");
  EXPECT_EQ(ways_of(slug, {"bodies[0].fixed=true"}), "");
  EXPECT_EQ(ways_of(slug, {"bodies[0].held_until=inf"}), "");
  EXPECT_EQ(ways_of(slug, {"bodies[0].velocity=[1, 0, 0]"}), "");
  // Liquid may hold it; that this falls out, too, is said of the liquid.
  EXPECT_EQ(ways_of(slug, {"fluids=[{material: wax, shape: {box: [[0.03,0,0.03],[0.07,0.03,0.07]]}}]"})
                .find("a run ends when a body is too fast"),
            std::string::npos);
  EXPECT_NE(ways_of(slug, {"solver.gravity=[0, 9.81, 0]"}).find("open face +y by t=0.12 s"),
            std::string::npos);
}

TEST(Halt, SaysThatABodyHasFallenOut) {
  const Scene scene = parse_scene(slug, "slug.yaml", "", {"solver.gravity=[0, -200, 0]"});
  Built built = build_world(scene, cpu_of_one());
  meltsim::StepResult now;
  for (int i = 0; i < 1000 && !now.halted; ++i) {
    static_cast<void>(built.world.step(0.0008));
    now = built.world.synchronize();
  }
  ASSERT_TRUE(now.halted);
  const std::string advice = halt_advice(scene, built.world, now, 0.0008, 1);
  EXPECT_EQ(advice.find("body \"slug\" has left the domain through its open face -y and is at (0.05, -"), 0u)
      << advice;
  EXPECT_NE(advice.find("only liquid is removed there: close the face (domain.walls: {-y: wall}), "),
            std::string::npos)
      << advice;
}

// The ends of the bar, whose outermost particles are 0.0765 m from the pivot, come down to the floor.
const std::string bar = R"(meltsim: 1
domain: {min: [0, 0, 0], max: [0.2, 0.1, 0.1]}
particles: {spacing: 0.01}
time: {end: 2, fps: 10}
heat: {model: none}
materials: {steel: {density: 7800}}
bodies: [{name: ladle, material: steel, motion: kinematic, angular_velocity: [0, 0, 1.5], max_speed: 0.3, pivot: [0.1, 0.05, 0.05], shape: {box: [[0.02, 0.03, 0.03], [0.18, 0.07, 0.07]]}}]
)";

TEST(Paths, ABodyThatTurnsIntoAWallIsRefusedBeforeTheRun) {
  const std::string said = ways_of(bar, {});
  EXPECT_EQ(
      said,
      "way.yaml:7:78: bodies[0].angular_velocity: [0, 0, 1.5] rad/s turns \"ladle\" through the wall -y "
      "at t=0.344 s, before time.end 2 s: the run would be refused there; use time.end 0.34 or less, "
      "another pivot, or a domain with more room");
  // As far as it says, and no further, a run goes.
  for (const double end : {0.34, 0.35}) {
    const Scene scene = parse_scene(bar, "bar.yaml", "", {});
    Built built = build_world(scene, cpu_of_one());
    EXPECT_EQ(static_cast<bool>(built.world.step(end)), end < 0.345) << end;
  }
  EXPECT_EQ(ways_of(bar, {"time.end=0.34"}), "");
  EXPECT_EQ(ways_of(bar, {"domain.max=[0.2, 0.2, 0.1]", "bodies[0].angular_velocity=[1.5, 0, 0]"}), "");
  EXPECT_EQ(ways_of(bar, {"domain.walls={y: open}"}), "");
  // About a pivot that moves along, until it comes to the end.
  EXPECT_NE(ways_of(bar, {"domain.max=[0.4, 0.2, 0.1]", "bodies[0].velocity=[0.1, 0, 0]",
                          "bodies[0].pivot=[0.1, 0.1, 0.05]",
                          "bodies[0].shape={box: [[0.02, 0.08, 0.03], [0.18, 0.12, 0.07]]}", "time.end=9"})
                .find("through the wall +x at t=2."),
            std::string::npos);
}

// 64 kg of ice at -100 C take up 6.4e6 J; as much water at 10 C gives off 6.4e5 J, and 1.92e7 J when it freezes.
const std::string cold = R"(meltsim: 1
domain: {min: [0, 0, 0], max: [1.2, 0.8, 0.8]}
particles: {spacing: 0.1}
time: {end: 0.1}
materials:
  water: {heat_capacity: 1000}
  ice: {melting_point: 0, latent_heat: 3e5, heat_capacity: 1000, becomes: water, freezes: true}
bodies: [{shape: {box: [[0, 0, 0], [0.4, 0.4, 0.4]]}, material: ice, temperature: -100}]
fluids: [{shape: {box: [[0.4, 0, 0], [0.8, 0.4, 0.4]]}, material: water, temperature: 10}]
)";

std::string balance_of(const std::vector<std::string>& set, bool melted_away = false) {
  const Scene scene = parse_scene(cold, "cold.yaml", "", set);
  Built built = build_world(scene, cpu_of_one());
  std::optional<HeatBalance> balance = heat_balance(scene, built);
  if (melted_away) balance->freezes_onto = false;
  return heat_balance_text(*balance, heat_sources_text(scene));
}

TEST(Balance, SaysWhatFreezesAndOntoWhat) {
  EXPECT_EQ(
      balance_of({}),
      "what is cold takes up 0.3 times what freezing gives off: in the end 30.0 % of what can freeze is "
      "frozen at 0 C");
  EXPECT_EQ(balance_of({"materials.ice.latent_heat=3e4"}),
            "what is cold takes up 3 times what freezing gives off: in the end all that can freeze is frozen "
            "at -30 C");
  EXPECT_EQ(
      balance_of({}, true),
      "what is cold takes up 0.3 times what freezing gives off: in the end all stays liquid, as there is "
      "nothing that it freezes onto, at 0 C");
}

TEST(Balance, CountsWhatEmittersBringThatStop) {
  // 0.2 * 0.2 * 1.6 * 0.1 m^3 of water until the end, 6.4 kg of 90 C: 5.76e5 J, and 1.92e6 J when they freeze.
  const std::string jet =
      "emitters=[{nozzle: {center: [0.9, 0.6, 0.4], axis: [1, 0, 0], width: 0.2, height: 0.2}, speed: 1.6, "
      "material: water, temperature: 90, until: ";
  const std::string said = balance_of({jet + "5}]"});
  EXPECT_EQ(
      said,
      "what is cold takes up 0.25 times what freezing gives off: in the end 24.5 % of what can freeze is "
      "frozen at 0 C");
  EXPECT_NE(
      balance_of({jet + "inf, max_particles: 9}]"})
          .find(
              "liquid and bodies by themselves come to an end where 30.0 % of what can freeze is frozen at 0 "
              "C; not counted: emitter"),
      std::string::npos);
}

TEST(Rehearsal, SaysWhatFreezes) {
  const Scene scene =
      parse_scene(cold, "cold.yaml", "",
                  {"heat.time_scale=1e6", "bodies[0].growth=4", "time.end=2", "solver.gravity=[0,0,0]"});
  Built built = build_world(scene, cpu_of_one());
  Rehearsal seen = rehearse(scene, built);
  EXPECT_GT(seen.frozen, 0.05);
  EXPECT_LT(seen.frozen, 0.35);
  EXPECT_EQ(seen.gone, std::vector<std::string>{});
  seen.frozen = 0.23, seen.coarseness = 1, seen.until = 2;
  EXPECT_EQ(freezing_text(seen, built, 2), "about 23 % of what can freeze is frozen by t=2 s (tried)");
  EXPECT_EQ(freezing_text(seen, built, 4),
            "about 23 % of what can freeze is frozen by t=2 s (tried); beyond that it was not tried");
  seen.frozen = 0;
  EXPECT_EQ(freezing_text(seen, built, 2),
            "next to nothing freezes by t=2 s; heat.time_scale makes it faster (tried)");
}

// Sugar in a glass: 0.64 kg of water hold 1.3 kg at a solubility of 0.67.
TEST(Saturation, SaysHowMuchOfABodyCanDissolve) {
  const std::string glass = R"(meltsim: 1
domain: {min: [0, 0, 0], max: [0.1, 0.1, 0.1]}
particles: {spacing: 0.01}
materials: {water: {}, sugar: {density: 1600, dissolves_in: water, solubility: 0.67, diffusivity_in: 1e-6}}
fluids: [{material: water, shape: {box: [[0, 0, 0], [0.1, 0.064, 0.1]]}}]
bodies: [{material: sugar, fixed: true, shape: {box: [[0, 0, 0], [0.1, 0.02, 0.1]]}}]
)";
  const auto of = [&glass](const std::vector<std::string>& set) {
    const Scene scene = parse_scene(glass, "glass.yaml", "", set);
    Built built = build_world(scene, cpu_of_one());
    return saturations(scene, built);
  };
  const auto whole = of({});
  ASSERT_EQ(whole.size(), 1u);
  EXPECT_NEAR(whole[0].crystals, 0.1 * 0.1 * 0.02 * 1600, 1e-6);
  EXPECT_NEAR(whole[0].holds, 0.67 / 0.33 * 0.4, 1e-6);  // four layers above the body
  EXPECT_EQ(whole[0].share(), 1);
  EXPECT_EQ(saturation_text(whole[0]),
            "sugar in water: saturated (0.67) the liquid holds 0.812 kg: everything can dissolve");
  const auto part = of({"materials.sugar.solubility=0.2", "fluids[0].fractions={sugar: 0.1}"});
  ASSERT_EQ(part.size(), 1u);
  EXPECT_NEAR(part[0].share(), (0.25 * 0.9 - 0.1) * (part[0].dissolved / 0.1) / 0.32, 1e-6);
  EXPECT_NE(saturation_text(part[0]).find(" of the bodies can dissolve"), std::string::npos)
      << saturation_text(part[0]);
  const auto over =
      of({"materials.sugar.solubility=[[0, 0.1], [20, 0.1], [80, 0.5]]", "fluids[0].fractions={sugar: 0.3}"});
  ASSERT_EQ(over.size(), 1u);
  EXPECT_NE(saturation_text(over[0]).find("what is too much settles on bodies"), std::string::npos)
      << saturation_text(over[0]);
  EXPECT_TRUE(of({"domain.walls={+y: open}"}).empty());
}

}  // namespace
}  // namespace runner
