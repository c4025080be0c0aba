// SPDX-License-Identifier: Apache-2.0
// Reading scenes: values, defaults, --set, and that the resolved scene is a scene again.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "build_world.hpp"
#include "builtin.hpp"
#include "failure.hpp"
#include "files.hpp"
#include "load_scene.hpp"
#include "resolution.hpp"
#include "scene_json.hpp"
#include "scene_options.hpp"
#include "template_scene.hpp"

namespace runner {
namespace {

const std::string small = R"(meltsim: 1
domain: {min: [0, 0, 0], max: [2, 2, 2], walls: {x: periodic, +y: open}}
particles: {spacing: 0.1, support: auto}
heat: {model: paper, time_scale: 5}
materials:
  ice: {density: 917, melting_point: 0, latent_heat: 3.34e5, becomes: water}
  water: {K: 1e-4}
fluids: [{shape: {box: [[0,0,0],[2,1,2]]}, material: water, temperature: 40}]
bodies: [{shape: {sphere: {center: [1,1.5,1], radius: 0.3}}, material: ice, density: 500, temperature: -5}]
)";

Scene parse(const std::string& text, const std::vector<std::string>& set = {}) {
  return parse_scene(text, "small.yaml", "", set);
}

std::string error_of(const std::string& text, const std::vector<std::string>& set = {}) {
  try {
    parse(text, set);
  } catch (const Failure& failure) {
    return failure.what();
  }
  return "no error";
}

TEST(Scene, ReadsValues) {
  const Scene scene = parse(small);
  EXPECT_EQ(scene.name, "small");
  EXPECT_EQ(scene.world.spacing, 0.1);
  EXPECT_EQ(scene.world.support_radius, 0);  // left to the library
  EXPECT_EQ(scene.world.heat.model, meltsim::HeatModel::paper);
  EXPECT_EQ(scene.world.domain.faces[0], meltsim::Face::periodic);
  EXPECT_EQ(scene.world.domain.faces[1], meltsim::Face::periodic);
  EXPECT_EQ(scene.world.domain.faces[2], meltsim::Face::wall);
  EXPECT_EQ(scene.world.domain.faces[3], meltsim::Face::open);
  ASSERT_EQ(scene.bodies.size(), 1u);
  EXPECT_EQ(scene.bodies[0].desc.name, "body1");
  EXPECT_EQ(scene.bodies[0].density, 500);
}

// A body named body2 first, so that the second, without a name, would have been called like it.
TEST(Scene, NamesThatNobodyGaveAreFree) {
  const std::string start =
      "meltsim: 1\nparticles: {spacing: 0.1}\ndomain: {min: [0, 0, 0], max: [2, 1, 1]}\n"
      "materials: {stone: {density: 2000}}\n";
  const auto body = [](const char* name, double x) {
    return fmt::format("  - {{{}material: stone, shape: {{box: [[{}, 0, 0], [{}, 0.3, 0.3]]}}}}\n", name, x,
                       x + 0.3);
  };
  const auto probe = [](const char* name) {
    return fmt::format("  - {{{}at: [1, 0.5, 0.5], fields: [pressure]}}\n", name);
  };
  const Scene scene = parse(start + "bodies:\n" + body("name: body2, ", 0) + body("", 0.5) + body("", 1) +
                            "probes:\n" + probe("") + probe("name: probe1, "));
  ASSERT_EQ(scene.bodies.size(), 3u);
  EXPECT_EQ(scene.bodies[1].desc.name, "body3");
  EXPECT_EQ(scene.bodies[2].desc.name, "body4");
  ASSERT_EQ(scene.probes.size(), 2u);
  EXPECT_EQ(scene.probes[0].desc.name, "probe2");
}

const std::string merged = R"(meltsim: 1
particles: {spacing: 0.1}
materials:
  water: &water {density: 1000, viscosity: 0.001, conductivity: 0.6}
  salty: &salty {<<: *water, density: 1100}
  brine: {viscosity: 0.002, <<: [*salty, *water, {heat_capacity: 3500}]}
)";

TEST(Scene, MergeKeysTakeWhatTheMappingLacks) {
  const Scene scene = parse(merged);
  ASSERT_EQ(scene.materials.size(), 3u);
  const meltsim::MaterialDesc &salty = scene.materials[1].desc, &brine = scene.materials[2].desc;
  EXPECT_EQ(salty.density, 1100);
  EXPECT_EQ(salty.viscosity, 0.001);
  EXPECT_EQ(brine.density, 1100);  // the first of the list wins
  EXPECT_EQ(brine.viscosity, 0.002);
  EXPECT_EQ(brine.conductivity, 0.6);
  EXPECT_EQ(brine.heat_capacity, 3500);
  // What --set changes is one mapping, not the one it was merged from.
  const Scene set = parse(merged, {"materials.brine.conductivity=2"});
  EXPECT_EQ(set.materials[0].desc.conductivity, 0.6);
  EXPECT_EQ(set.materials[2].desc.conductivity, 2);
}

TEST(Scene, AMappingThatMergesItselfIsReadAll) {
  EXPECT_NE(error_of("&all {meltsim: 1, particles: {spacing: 0.1, <<: *all}}")
                .find("unknown key \"meltsim\" in particles"),
            std::string::npos);
}

TEST(Scene, WarnsOfForceFieldsThatDoNothing) {
  const auto said = [](const std::string& field) {
    const Scene scene = parse("meltsim: 1\nparticles: {spacing: 0.1}\nforce_fields: [" + field + "]\n");
    return scene.warnings.empty() ? "" : scene.warnings.front();
  };
  EXPECT_EQ(
      said("{kind: vortex, strength: 0}"),
      "small.yaml:3:41: force_fields[0].strength: is 0 m/s^2: the field moves nothing; give it a value, or "
      "remove the field");
  EXPECT_NE(said("{kind: uniform}").find("force_fields[0].acceleration: is 0 m/s^2"), std::string::npos);
  EXPECT_NE(said("{kind: radial}").find("force_fields[0].strength: is 0 m/s^2"), std::string::npos);
  EXPECT_NE(said("{kind: drag}").find("force_fields[0].rate: is 0 per second"), std::string::npos);
  EXPECT_EQ(said("{kind: vortex, strength: -1}"), "");
}

const std::string tea = R"(meltsim: 1
domain: {min: [0, 0, 0], max: [2, 2, 2]}
particles: {spacing: 0.1}
solute: {time_scale: 20, max_supersteps: 7}
materials:
  sugar: {density: 1590, dissolves_in: tea, solubility: 0.6, diffusivity_in: 5e-10, heat_of_solution: 1.6e4,
          transfer_coefficient: 5e-5}
  milk: {density: 1030, dissolves_in: tea, diffusivity_in: 1e-9}
  tea: {}
fluids: [{shape: {box: [[0,0,0],[2,1,2]]}, material: tea, fractions: {milk: 0.1, sugar: 0.05}}]
bodies: [{shape: {sphere: {center: [1,1.5,1], radius: 0.3}}, material: sugar}]
emitters: [{nozzle: {center: [1.7, 1.7, 1], radius: 0.1}, material: tea, until: 0.1, fractions: {milk: 1}}]
)";

TEST(Scene, ReadsWhatChannelsAndSharedHeatAre) {
  EXPECT_EQ(parse(tea).world.heat.interval, 1);
  EXPECT_EQ(parse(tea, {"heat.interval=auto"}).world.heat.interval, 0);
  EXPECT_EQ(parse(tea, {"heat.interval=6"}).world.heat.interval, 6);
  EXPECT_EQ(parse(tea, {"solver.density_error=0.02"}).world.density_error, 0.02);
  const Scene scene =
      parse(tea, {"domain.outlets={+x: {level: 0.5}, -z: {speed: 2}}", "bodies[0].held_until=3"});
  EXPECT_EQ(scene.world.domain.outlets[1].level, 0.5);
  EXPECT_EQ(scene.world.domain.outlets[4].speed, 2);
  EXPECT_EQ(scene.bodies[0].desc.held_until, 3);
}

TEST(Scene, ReadsSpecies) {
  const Scene scene = parse(tea);
  EXPECT_EQ(scene.world.solute.time_scale, 20);
  EXPECT_EQ(scene.world.solute.max_supersteps, 7);
  ASSERT_EQ(scene.materials.size(), 3u);
  EXPECT_EQ(scene.materials[0].desc.name, "tea");  // before what dissolves in it
  EXPECT_EQ(scene.materials[1].desc.solubility, 0.6);
  EXPECT_EQ(scene.materials[1].desc.diffusivity_in, 5e-10);
  EXPECT_EQ(scene.materials[1].desc.heat_of_solution, 1.6e4);
  EXPECT_EQ(scene.materials[1].desc.transfer_coefficient, 5e-5);
  EXPECT_EQ(scene.fluids[0].fractions, (SceneFractions{{"milk", 0.1}, {"sugar", 0.05}}));
  MachineOptions machine;
  machine.backend = meltsim::Backend::cpu;
  Built built = build_world(scene, machine);
  const meltsim::ParticleData p = *built.world.particles();
  ASSERT_EQ(p.species.size(), 2u);
  EXPECT_NEAR(p.fractions[0].front(), 0.05, 1e-12);  // sugar comes first
  EXPECT_NEAR(p.fractions[1].front(), 0.1, 1e-12);
  EXPECT_EQ(p.fractions[0].back(), 1);  // of the body
  EXPECT_EQ(built.meltable, p.id.size() - built.fluid_particles[0]);
  // What is echoed reads as the same scene.
  const Json echoed = scene_json(scene, built.world.resolved());
  const Scene again = parse(echoed.dump());
  EXPECT_EQ(scene_json(again, built.world.resolved()), echoed);
  EXPECT_EQ(again.emitters[0].fractions, (SceneFractions{{"milk", 1}}));
}

TEST(Scene, SaysWhatIsWrongWithSpecies) {
  EXPECT_NE(error_of(tea, {"materials.milk.dissolves_in=teaa"})
                .find("materials.milk.dissolves_in: no material is named \"teaa\"; did you mean \"tea\"?"),
            std::string::npos)
      << error_of(tea, {"materials.milk.dissolves_in=teaa"});
  EXPECT_NE(error_of(tea, {"materials.tea.dissolves_in=milk"}).find("leads back to"), std::string::npos);
  EXPECT_NE(error_of(tea, {"fluids[0].fractions={cream: 0.1}"}).find("no material is named \"cream\""),
            std::string::npos);
  EXPECT_NE(error_of(tea, {"solute.time_scale=-1"}).find("solute.time_scale: expected a factor from 0"),
            std::string::npos);
  const auto built = [](const std::string& set) {
    MachineOptions machine;
    machine.backend = meltsim::Backend::cpu;
    try {
      build_world(parse(tea, {set}), machine);
    } catch (const Failure& failure) {
      return std::string(failure.what());
    }
    return std::string("no error");
  };
  for (const auto& [set, message] :
       {std::pair{"materials.sugar.diffusivity_in=-1",
                  "materials.sugar.diffusivity_in: must be finite and > 0"},
        {"materials.sugar.solubility=2", "materials.sugar.solubility: must be in (0, 1]"},
        {"fluids[0].fractions={sugar: 0.7}", "fluids[0].fractions: "},
        {"solute.max_supersteps=0", "solute.max_supersteps: must be in 1..1000000"}})
    EXPECT_NE(built(set).find(message), std::string::npos) << built(set);
}

std::string warning_of(const std::vector<std::string>& set) {
  const std::vector<std::string> warnings = parse(small, set).warnings;
  return warnings.empty() ? "" : warnings.size() == 1 ? warnings[0] : "several warnings";
}

// Beside 1e4 m numbers of single precision are 2^-10 m apart, beside 2e5 m 2^-6 m; a hundredth of a spacing is 1e-3 m here.
TEST(Scene, WarnsWhereFilesCannotHoldPlaces) {
  EXPECT_EQ(warning_of({"domain.max=[2, 1e4, 2]"}), "");
  EXPECT_NE(
      warning_of({"domain.max=[2, 2e5, 2]"})
          .find("domain.max: 200000 m from the origin files of frames hold places to 0.016 m, 0.16 spacings"),
      std::string::npos);
  EXPECT_NE(warning_of({"domain.min=[0, -2e5, 0]"}).find("200000 m from the origin"), std::string::npos);
  EXPECT_EQ(warning_of({"domain.max=[2, 2e5, 2]", "output.export=[png]"}), "");
}

// Liquid fills a tank of broken spacings, what lies in it keeps to whole ones.
TEST(Scene, WarnsWhereLiquidIsStretchedBesideABody) {
  const std::string tank = "domain.max=[2.1, 3, 2]",
                    water = "fluids[0].shape={box: [[0, 0, 0], [2.1, 1, 2]]}",
                    stone = "bodies[0].shape={box: [[0.5, 0, 0.5], [1, 0.8, 1]]}",
                    above = "bodies[0].shape={box: [[0.5, 1, 0.5], [1, 1.8, 1]]}",
                    across = "bodies[0].shape={box: [[0, 0, 0.5], [2.1, 0.8, 1]]}";
  EXPECT_NE(
      warning_of({"particles.spacing=0.2", tank, water, stone})
          .find("domain.max: 2.1 m along x are 10.5 spacings of 0.2 m: liquid from wall to wall is squeezed"),
      std::string::npos);
  EXPECT_NE(warning_of({"particles.spacing=0.2", tank, water, stone})
                .find("use a spacing of 0.190909 m, or make it 2.2 m"),
            std::string::npos);
  EXPECT_EQ(warning_of({"particles.spacing=0.1", tank, water, stone}), "");   // 21 of them
  EXPECT_EQ(warning_of({"particles.spacing=0.2", tank, water, above}), "");   // not in it
  EXPECT_EQ(warning_of({"particles.spacing=0.2", tank, water, across}), "");  // stretched likewise
}

TEST(Scene, WarnsOfUnitsThatLookLikeSlips) {
  EXPECT_EQ(warning_of({}), "");
  EXPECT_EQ(warning_of({"fluids[0].temperature=95"}), "");
  EXPECT_EQ(warning_of({"materials.water.heat_capacity=4186", "fluids[0].temperature=313"}),
            "--set fluids[0].temperature=313: fluids[0].temperature: water at 313 degrees Celsius; Kelvin? "
            "Then write 39.85");
  EXPECT_EQ(warning_of({"bodies[0].temperature=263"}),
            "--set bodies[0].temperature=263: bodies[0].temperature: ice at 263 degrees Celsius; Kelvin? "
            "Then write -10.15");
  EXPECT_NE(warning_of({"materials.ice.melting_point=273.15"}).find("Kelvin? Then write 0"),
            std::string::npos);
  EXPECT_NE(warning_of({"materials.ice.latent_heat=334"})
                .find("materials.ice.latent_heat: 334 J/kg is less than any "
                      "material has; kilojoules? Then write 334000"),
            std::string::npos);
  EXPECT_NE(warning_of({"materials.ice={density: 917, melting_point: 0, becomes: water}"})
                .find("materials.ice.melting_point: melting takes no heat: there is no latent_heat"),
            std::string::npos);
  EXPECT_EQ(warning_of({"materials.ice={density: 917, melting_point: 0, latent_heat: 0, becomes: water}"}),
            "");
  EXPECT_NE(warning_of({"materials.water.heat_capacity=4.186"}).find("kilojoules? Then write 4186"),
            std::string::npos);
  EXPECT_EQ(warning_of({"materials.ice.heat_capacity=120"}), "");  // uranium's is 116
  const std::string sugar =
      "materials.sugar={density: 1590, dissolves_in: water, solubility: 0.6, diffusivity_in: 1e-9";
  EXPECT_EQ(warning_of({sugar + ", heat_of_solution: 1.6e4}"}), "");
  EXPECT_NE(warning_of({sugar + ", heat_of_solution: -16}"})
                .find("heat_of_solution: -16 J/kg changes next to nothing; "
                      "kilojoules? Then write -16000"),
            std::string::npos);
  EXPECT_NE(warning_of({sugar + ", heat_capacity: 1250}"}).find("heat_capacity: 1250 J/(kg K) is not used"),
            std::string::npos);
  const char* const lid = "domain.velocity={+y: [1, 0, 0]}";
  EXPECT_EQ(warning_of({lid}), "");
  EXPECT_NE(warning_of({lid, "domain.no_slip=false"}).find("domain.velocity: liquid does not stick to walls"),
            std::string::npos);
  // Molten metal is hot: no water, and no solid far above its melting point.
  EXPECT_EQ(warning_of({"materials.water.density=7000", "materials.water.heat_capacity=500",
                        "fluids[0].temperature=1500"}),
            "");
  EXPECT_NE(warning_of({"materials.ice.density=0.917"}).find("0.917 kg/m^3 is no density"),
            std::string::npos);
  EXPECT_NE(warning_of({"materials.water.density=1"}).find("(10 to 25000); 1 g/cm^3 is 1000"),
            std::string::npos);
  EXPECT_NE(warning_of({"bodies[0].density=3e4"}).find("30000 kg/m^3 is no density"), std::string::npos);
  EXPECT_EQ(warning_of({"bodies[0].density=22590"}), "");  // osmium
}

TEST(Scene, WarnsOfWhatMeltsOrFreezesInTheFirstFrame) {
  EXPECT_EQ(warning_of({"bodies[0].temperature=0"}), "");
  EXPECT_EQ(warning_of({"bodies[0].temperature=20"}),
            "--set bodies[0].temperature=20: bodies[0].temperature: ice starts at 20 C, above its melting "
            "point of 0 C, and begins to melt at once; give it a temperature of at most 0");
  EXPECT_NE(warning_of({"bodies=[{shape: {box: [[0,1,0],[1,2,1]]}, material: ice}]"})
                .find("ice starts at 20 C, the default, above"),
            std::string::npos);
  EXPECT_EQ(warning_of({"bodies[0].temperature=20", "heat={model: none}"}), "");
  EXPECT_EQ(warning_of({"fluids[0].temperature=-3"}), "");  // nothing freezes
  EXPECT_EQ(
      warning_of({"fluids[0].temperature=-3", "materials.ice.freezes=true", "heat.model=enthalpy"}),
      "--set fluids[0].temperature=-3: fluids[0].temperature: water starts at -3 C, below the melting "
      "point of ice, 0 C, and freezes at once where it touches it; give it a temperature of at least 0");
}

TEST(Scene, ADomainInsideOutIsBlamedItself) {
  EXPECT_EQ(
      error_of(small, {"domain.max=[2, -2, 2]", "probes=[{name: p, at: [1, 1, 1], fields: [velocity]}]"}),
      "--set domain.max=[2, -2, 2]: domain.max: must be above domain.min along y, got extent -2 m; swap or "
      "enlarge the corners");
}

TEST(Scene, WarnsOfASoundSlowerThanTheFall) {
  // From 1.8 m to the floor: 5.94 m/s.
  EXPECT_NE(warning_of({"solver.sound_speed=5"}).find("things reach 5.94 m/s by falling"), std::string::npos);
  EXPECT_EQ(warning_of({"solver.sound_speed=18"}), "");
  EXPECT_NE(warning_of({"solver.sound_speed=18", "fluids[0].velocity=[0, 0, -20]"}).find("20.9 m/s"),
            std::string::npos);
  EXPECT_EQ(warning_of({"solver.sound_speed=5", "solver.gravity=[0, 0, 0]"}), "");
}

// Kelvin of everyday temperatures around a scene of ice and water; a heater of 250 C is none, and nor is what is as hot as the scene.
TEST(Scene, WarnsOfKelvinInWallsSurfacesAndRegions) {
  const std::string said = ": 253 degrees Celsius; Kelvin? Then write -20.15";
  EXPECT_EQ(
      warning_of({"heat.walls={-y: {temperature: 253}}"}).find("--set heat.walls={-y: {temperature: 253}}: "),
      0u);
  for (const char* set :
       {"heat.walls={-y: {temperature: 253}}", "heat.free_surface={convection: 10, ambient: 253}",
        "bodies[0].surface={convection: 10, ambient: 253}",
        "heat.regions=[{shape: {box: [[0, 0, 0], [1, 1, 1]]}, temperature: 253}]"})
    EXPECT_NE(warning_of({set}).find(said), std::string::npos) << set << " " << warning_of({set});
  for (const char* set : {"heat.walls={-y: {temperature: 250}}", "heat.walls={-y: {temperature: -20}}",
                          "heat.walls={-y: {temperature: 853}}"})
    EXPECT_EQ(warning_of({set}), "") << set;
  // Whole degrees that were converted are told by their .15 in a scene of hot metal, too.
  const std::string metal =
      "materials.ice={density: 2400, melting_point: 1070, latent_heat: 4e5, becomes: water}";
  EXPECT_EQ(warning_of({metal, "heat.walls={-y: {temperature: 853}}"}), "");
  EXPECT_NE(warning_of({metal, "heat.walls={-y: {temperature: 293.15}}"}).find("Then write 20"),
            std::string::npos);
  EXPECT_NE(
      warning_of({"materials.ice={density: 2400, melting_point: 1343.15, latent_heat: 4e5, becomes: water}"})
          .find("melting_point: 1343.15 degrees Celsius; Kelvin? Then write 1070"),
      std::string::npos);
}

// Whole kelvins of a scene in which nothing is colder: 293 to 1811, 300 to 1773. Parts that are preheated to 250 or 300 degrees are none.
TEST(Scene, WarnsOfWholeKelvinByTheColdestOfAScene) {
  const auto metal = [](const std::string& melts, const std::string& start) {
    return warning_of(
        {"materials.ice={density: 2400, melting_point: " + melts + ", latent_heat: 4e5, becomes: water}",
         "bodies[0].temperature=" + start, "fluids[0].temperature=" + melts});
  };
  EXPECT_NE(metal("1811", "293")
                .find("nothing is colder than 293 degrees Celsius; Kelvin? Temperatures are in degrees "
                      "Celsius: 293 K are 19.85"),
            std::string::npos);
  EXPECT_NE(metal("1773", "300").find("300 K are 26.85"), std::string::npos);
  EXPECT_EQ(metal("1540", "300"), "");
  EXPECT_EQ(metal("1538", "20"), "");
  EXPECT_EQ(metal("1538", "400"), "");
}

// Points in Kelvin among temperatures of a scene in degrees Celsius, -5 to 20; those of a melt that a source heats are beyond them, too.
TEST(Scene, WarnsOfTablesInKelvin) {
  const auto with = [](const std::string& points) {
    return warning_of({"fluids[0].temperature=20", "materials.water.viscosity=" + points});
  };
  EXPECT_NE(
      with("[[283, 2e-3], [303, 1e-3]]")
          .find("materials.water.viscosity: its points begin at 283 degrees Celsius, above all temperatures "
                "of the "
                "scene (-5 to 20), so that only the first one counts; Kelvin? Then write 9.85 for 283"),
      std::string::npos);
  EXPECT_EQ(with("[[0, 2e-3], [303, 1e-3]]"), "");
  EXPECT_EQ(with("[[30, 2e-3], [90, 1e-3]]"), "");
  EXPECT_EQ(with("[[900, 2e-3], [1000, 1e-3]]"), "");
}

TEST(Scene, WarnsOfAModulusInMegapascals) {
  const auto with = [](const std::string& density, const std::string& modulus) {
    return warning_of({"materials.brick={density: " + density + ", youngs_modulus: " + modulus + "}"});
  };
  EXPECT_NE(
      with("7800", "2.1e5")
          .find("brick.youngs_modulus: 210000 Pa is that of jelly, at 7800 kg/m^3; MPa? Then write 2.1e+11"),
      std::string::npos);
  EXPECT_EQ(with("7800", "2.1e11"), "");
  EXPECT_EQ(with("7800", "1e7"), "");  // softer, for longer steps
  EXPECT_EQ(with("1100", "1e5"), "");
}

TEST(Scene, WarnsOfASurfaceTensionInMillinewtons) {
  EXPECT_NE(warning_of({"materials.water.surface_tension=72"}).find("mN/m? Then write 0.072"),
            std::string::npos);
  EXPECT_EQ(warning_of({"materials.water.surface_tension=1.8"}), "");
}

TEST(Scene, WarnsOfALatentHeatThatIsOfNoUse) {
  EXPECT_EQ(warning_of({"materials.water.latent_heat=3.34e5"}),
            "--set materials.water.latent_heat=3.34e5: materials.water.latent_heat: is of no use: it is of "
            "melting, "
            "and the material has no melting_point; give it one and `becomes`, or give latent_heat to the "
            "solid that "
            "becomes it");
}

TEST(Scene, CountsTheOpenEdgesOfAMesh) {
  const std::string path = testing::TempDir() + "open_cube.obj";
  std::string cube;
  for (int i = 0; i < 8; ++i)
    cube += "v " + std::to_string(i & 1) + " " + std::to_string(i >> 1 & 1) + " " +
            std::to_string(i >> 2 & 1) + "\n";
  for (const char* face : {"1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3"})
    cube += std::string("f ") + face + "\n";
  write_file(path, cube);
  const std::vector<std::string> mesh{"bodies[0].shape={mesh: " + path + "}", "bodies[0].density=900"};
  EXPECT_NE(warning_of(mesh).find("the mesh is open: 4 of its edges belong to one triangle only"),
            std::string::npos);
  write_file(path, cube + "f 2 4 8 6\n");
  EXPECT_EQ(warning_of(mesh), "");
  // The same cube, each face with vertices of its own, as STL has them.
  std::string apart;
  for (const auto& face : {"000 010 110 100", "001 101 111 011", "000 100 101 001", "010 011 111 110",
                           "000 001 011 010", "100 110 111 101"}) {
    const std::string corners = face;
    for (std::size_t i = 0; i < 16; i += 4)
      apart += std::string("v ") + corners[i] + " " + corners[i + 1] + " " + corners[i + 2] + "\n";
    apart += "f -1 -2 -3 -4\n";
  }
  write_file(path, apart);
  EXPECT_EQ(warning_of(mesh), "");
  // And with the last face off by a rounding: there is no hole to close.
  const std::size_t last = apart.rfind("v 1 0 0");
  std::string off = apart.substr(last);
  for (std::size_t at = off.find("v 1 "); at != std::string::npos; at = off.find("v 1 ", at + 1))
    off.replace(at, 3, "v 1.000001");
  write_file(path, apart.substr(0, last) + off);
  EXPECT_NE(warning_of(mesh).find(
                "the mesh is open: 8 of its edges belong to one triangle only; what is inside is a "
                "guess there, so merge its vertices by distance: "),
            std::string::npos)
      << warning_of(mesh);
}

TEST(Scene, LiquidsComeBeforeWhatBecomesThem) {
  const Scene scene = parse(small);
  ASSERT_EQ(scene.materials.size(), 2u);
  EXPECT_EQ(scene.materials[0].desc.name, "water");
  EXPECT_EQ(scene.materials[0].desc.diffusivity, 1e-4);
  EXPECT_EQ(scene.materials[1].becomes, "water");
}

TEST(Scene, FreezingIsReadAndWrittenBack) {
  const std::string text = R"(meltsim: 1
particles: {spacing: 0.1}
materials:
  ice: {melting_point: 0, becomes: water, freezes: true}
  water: {}
bodies: [{shape: {sphere: {center: [1,1.5,1], radius: 0.3}}, material: ice, growth: 3}]
)";
  const Scene scene = parse(text);
  EXPECT_TRUE(scene.materials[1].desc.freezes);
  EXPECT_FALSE(scene.materials[0].desc.freezes);
  EXPECT_EQ(scene.bodies[0].desc.growth, 3);
  meltsim::Resolved resolved;
  resolved.support_radius = 0.25;
  const Json json = scene_json(scene, resolved);
  EXPECT_EQ(json["materials"]["ice"]["freezes"], true);
  EXPECT_EQ(json["bodies"][0]["growth"], 3);
  EXPECT_EQ(parse(json.dump()).bodies[0].desc.growth, 3);
}

TEST(Scene, JsonIsAScene) {
  const Scene scene = parse(R"({
	"meltsim": 1, "particles": {"spacing": 0.1},
	"materials": {"a/b": {"density": 900, "melting_point": "inf"}},
	"emitters": [{"nozzle": {"center": [0, 1, 0], "radius": 0.2}, "material": "a/b", "until": "inf"}]
})");
  EXPECT_EQ(scene.materials[0].desc.density, 900);
  EXPECT_EQ(scene.emitters[0].desc.until, meltsim::infinity);
}

TEST(Scene, SetReplacesAndAdds) {
  const Scene scene =
      parse(small, {"heat.model=none", "bodies[0].temperature=-5", "materials.water.viscosity=0.5",
                    "solver.gravity=[0, 0, -1]", "time.end=3"});
  EXPECT_EQ(scene.world.heat.model, meltsim::HeatModel::none);
  EXPECT_EQ(scene.bodies[0].desc.temperature, -5);
  EXPECT_EQ(scene.materials[0].desc.viscosity, 0.5);
  EXPECT_EQ(scene.world.gravity.z, -1);
  EXPECT_EQ(scene.time.end, 3);
}

/// Everything that a scene can list, with every key of it.
const std::string full = R"(meltsim: 1
domain: {min: [0, 0, 0], max: [2, 2, 2], walls: {+x: open}, outlets: {+x: {speed: 1}}}
particles: {spacing: 0.2}
materials:
  water: {viscosity: 0.1}
  ice: {melting_point: 0, becomes: water, latent_heat: 3e5}
  milk: {dissolves_in: water, diffusivity_in: 1e-9}
heat: {regions: [{name: oven, shape: {box: [[0,0,0],[1,1,1]]}, temperature: 50, from: 0, until: 3,
                  path: [[0, 0, 0, 0], [1, 0.5, 0, 0]]},
                 {shape: {box: [[0,0,0],[1,1,1]]}, source: 7}]}
fluids: [{shape: {box: [[0,0,0],[2,1,2]]}, material: water, temperature: 10, velocity: [1,0,0],
          fractions: {milk: 0.1}}]
bodies: [{name: a, shape: {sphere: {center: [1,1.5,1], radius: 0.3}}, material: ice, density: 900,
          temperature: -5, velocity: [0,1,0], angular_velocity: [0,0,2], fixed: false, held_until: 1,
          motion: rigid, pivot: [1,1,1], max_speed: 3, carve: false, visible: false, surface: {flux: 3}, heat_source: 2,
          growth: 1, path: [[0, 0, 0, 0], [1, 0.1, 0, 0, 90]], path_axis: [1,0,0]}]
emitters: [{name: e, nozzle: {center: [1.7,1.7,1], axis: [1,0,0], radius: 0.2}, speed: 2, material: water,
            temperature: 3, from: 0.1, until: 0.2, max_particles: 30, recycle: true, fractions: {milk: 1}},
           {nozzle: {center: [1,1,1], width: 0.4, height: 0.5, up: [1,0,0]}, material: water, until: 1},
           {reservoir: {face: +x, level: 0.5, height: 0.8}, material: water}]
force_fields: [{name: f, kind: vortex, shape: {box: [[0,0,0],[1,1,1]]}, center: [1,1,1], axis: [1,0,0],
                strength: 1, radius: 0.1, power: -1, liquid: false, bodies: true, from: 0.1, until: 2},
               {kind: drag, velocity: [1,0,0], angular_velocity: [0,0,1], rate: 3},
               {kind: uniform, acceleration: [0,1,0], bodies: false}]
probes: [{name: p, at: [1,1,1], fields: [pressure], every: 0.1}, {kind: level, at: [1,1,1]},
         {kind: force, body: a, about: [1,1,1], fields: [moment]}, {kind: heat, wall: -y},
         {kind: flux, at: [1,1,1], normal: [0,1,0], radius: 0.1, fields: [volume_flux]},
         {kind: flux, at: [1,1,1], normal: [0,1,0], size: [0.1,0.2], along: [1,0,0], every: step}]
trade: {observe: [melted], max_error: 3%, exact: {melted: [[0,0],[1,1]], height: 2}}
output: {export: [vtp], surface: {cell: 0.1, kernel: anisotropic, smoothing: 3, closed_at_solids: true},
         camera: {eye: [0,0,0], look_at: [1,1,1], up: [0,1,0], fov: 30},
         picture: {width: 320, height: 240, samples: 1, look: temperature}}
)";

TEST(Scene, WhatIsEchoedIsTheSameSceneWithEveryKeyGiven) {
  const Scene scene = parse(full);
  meltsim::Resolved resolved;
  resolved.support_radius = 0.5;
  resolved.sound_speed = 30;
  const Json json = scene_json(scene, resolved);
  EXPECT_EQ(scene_json(parse(json.dump()), resolved), json);
  // Of the lists, whatever was given is there.
  const auto holds = [](const Json& item, const keys::List& keys) {
    for (const std::string& key : keys) EXPECT_TRUE(item.contains(key)) << key << " of " << item;
  };
  holds(json["heat"]["regions"][0], {"name", "shape", "temperature", "from", "until", "path"});
  holds(json["fluids"][0], keys_of(fluid_options()));
  holds(json["bodies"][0], keys_of(body_options()));
  keys::List of_nozzle = keys_of(emitter_options());
  of_nozzle.erase(std::find(of_nozzle.begin(), of_nozzle.end(), "reservoir"));
  holds(json["emitters"][0], of_nozzle);
  holds(json["emitters"][2]["reservoir"], keys_of(reservoir_options()));
  EXPECT_EQ(json["emitters"][2]["reservoir"]["face"], "+x");
  holds(json["emitters"][1]["nozzle"], {"center", "axis", "width", "height", "up"});
  holds(json["force_fields"][0], {"name", "kind", "shape", "center", "axis", "strength", "radius", "power",
                                  "liquid", "bodies", "from", "until"});
  holds(json["probes"][2], {"name", "kind", "body", "about", "fields", "every"});
  holds(json["probes"][5], {"name", "kind", "at", "normal", "size", "along", "fields", "every"});
  for (const char* part : {"surface", "camera", "picture"})
    EXPECT_EQ(json["output"][part].size(), 4u) << json["output"];
  holds(json["trade"], keys_of(trade_options()));
}

TEST(Scene, KeysOfAnotherKindAndNamesOfTheLibraryAreAnsweredWithWhatToWrite) {
  for (const auto& [set, message] :
       {std::pair{"materials.water.yield_stress_points=[[0, 10], [50, 0]]",
                  "unknown key \"yield_stress_points\" in materials.water; give the points as the value of "
                  "\"yield_stress\": [[temperature, value], ...]"},
        {"materials.ice.melts_into=water",
         "unknown key \"melts_into\" in materials.ice; did you mean \"becomes\"?"},
        {"force_fields[2].rate=1",
         "force_fields[2].rate: kind uniform has no rate; leave it out, or write kind: drag"},
        {"probes[3].fields=[force]",
         "probes[3].fields: kind heat has no fields; leave them out, or write kind: point, force or flux"},
        {"output=[1, 2]", "output: expected a mapping {key: value}, got a list of 2"},
        {"domain=[1, 2]", "domain: expected a mapping {key: value}, got a list of 2"}})
    EXPECT_EQ(error_of(full, {set}), std::string("--set ") + set + ": " + message);
}

TEST(Scene, WhatTheLibraryFindsAtANozzleIsShownAtItsKey) {
  MachineOptions machine;
  machine.backend = meltsim::Backend::cpu;
  const std::string set = "emitters[0].nozzle.radius=0.05";
  try {
    build_world(parse(full, {set, "bodies=[]", "probes=[]", "domain.walls=box", "domain.outlets={}"}),
                machine);
    FAIL();
  } catch (const Failure& failure) {
    EXPECT_EQ(std::string(failure.what()).find("--set " + set + ": emitters[0].nozzle.radius: "), 0u)
        << failure.what();
  }
}

TEST(Scene, SetErrorsNameTheOption) {
  EXPECT_EQ(error_of(small, {"heatt.model=none"}),
            "--set heatt.model=none: unknown key \"heatt\" in the scene; did you mean \"heat\"?");
  EXPECT_EQ(error_of(small, {"domain={min: [0,0,0], max: [2,2]}"}),
            "--set domain={min: [0,0,0], max: [2,2]}: domain.max: expected 3 numbers [x, y, z] (m), got a "
            "list of 2");
  EXPECT_EQ(error_of(small, {"bodies.density=3"}), "--set bodies.density=3: bodies has no keys");
}

TEST(Scene, ScaleKeepsTheRatioOfSupportToSpacing) {
  Scene scene = parse(small, {"particles.support=0.25"});
  apply_resolution(scene, 0.8, Quality::balanced);
  EXPECT_DOUBLE_EQ(scene.world.spacing, 0.125);
  EXPECT_DOUBLE_EQ(scene.world.support_radius, 0.3125);
}

// 4.8 m are 16.8 spacings of 0.2/0.7 m: the last layer would stand 0.3 spacings from the wall.
TEST(Scene, ScaledSpacingFitsBetweenTheWalls) {
  const std::vector<std::string> tank = {"domain={min: [0,0,0], max: [4.8,4,4.8], walls: box}"};
  for (const double scale : {0.7, 0.83, 1.3}) {
    Scene scene = parse(small, tank);
    const double wanted = scene.world.spacing / scale;
    apply_resolution(scene, scale, Quality::balanced);
    const double cells = 4.8 / scene.world.spacing;
    EXPECT_NEAR(cells, std::round(cells), 1e-9) << scale;
    EXPECT_NEAR(scene.world.spacing, wanted, 0.06 * wanted);
  }
  // 0.8 m are 7.5 of 0.08/0.75 m; 4 m are 37.5. With 0.1 m both fit.
  Scene narrow =
      parse(small, {"particles.spacing=0.08", "domain={min: [0,0,0], max: [4,2.4,0.8], walls: box}"});
  apply_resolution(narrow, 0.75, Quality::balanced);
  EXPECT_DOUBLE_EQ(narrow.world.spacing, 0.1);
  Scene same = parse(small, tank);
  apply_resolution(same, 1, Quality::balanced);
  EXPECT_DOUBLE_EQ(same.world.spacing, 0.1);
}

TEST(Scene, QualityChangesSoundSpeedOrResolution) {
  Scene draft = parse(small), named = parse(small, {"solver.sound_speed=20"}), accurate = parse(small);
  apply_resolution(draft, 1, Quality::draft);
  apply_resolution(named, 1, Quality::draft);
  apply_resolution(accurate, 1, Quality::accurate);
  EXPECT_NEAR(draft.world.spacing, 0.1 / 0.8, 0.06 * 0.1 / 0.8);  // moved to fit between the walls
  EXPECT_DOUBLE_EQ(draft.sound_factor, 0.8);
  EXPECT_DOUBLE_EQ(draft.world.courant, 0.5);
  EXPECT_DOUBLE_EQ(named.world.sound_speed, 16);
  EXPECT_NEAR(accurate.world.spacing, 0.1 / 1.4, 0.06 * 0.1 / 1.4);  // moved to fit between the walls
  EXPECT_DOUBLE_EQ(accurate.world.courant, 0.4);
  const MachineOptions cpu{meltsim::Backend::cpu, meltsim::Precision::single_precision, 1, 1};
  // The scene as coarse as the draft: how high a lattice is goes into the sound speed that is derived.
  Scene coarse = parse(small);
  apply_resolution(coarse, 0.8, Quality::balanced);
  const double automatic = build_world(coarse, cpu).world.resolved().sound_speed;
  EXPECT_NEAR(build_world(draft, cpu).world.resolved().sound_speed, 0.8 * automatic, 1e-6 * automatic);
}

TEST(Scene, ShapesEndUpWhereTheTransformPutsThem) {
  const Scene scene = parse(R"(meltsim: 1
particles: {spacing: 0.1}
materials: {ice: {}}
bodies:
  - material: ice
    shape: {box: [[0, 0, 0], [2, 1, 1]], transform: {offset: [10, 0, 0], axis: [0, 1, 0], angle: 90, scale: 2}}
)");
  const meltsim::Box box = scene.bodies[0].desc.shape.bounds();
  EXPECT_NEAR(box.min.x, 10, 1e-6);
  EXPECT_NEAR(box.max.x, 12, 1e-6);
  EXPECT_NEAR(box.min.z, -4, 1e-6);
}

TEST(Scene, ResolvedSceneIsTheSameScene) {
  for (const BuiltinScene& builtin : builtin_scenes()) {
    meltsim::Resolved resolved;
    resolved.support_radius = 0.3;
    resolved.sound_speed = 40;
    const Json once = scene_json(parse_scene(builtin.text, builtin.name, "", {}), resolved);
    const Json twice = scene_json(parse_scene(once.dump(), builtin.name, "", {}), resolved);
    EXPECT_EQ(once.dump(2), twice.dump(2)) << builtin.name;
  }
}

TEST(Scene, BuiltinsAndTheTemplateAreValid) {
  EXPECT_NE(find_builtin("ice_block"), nullptr);
  for (const BuiltinScene& builtin : builtin_scenes()) {
    EXPECT_NO_THROW(parse_scene(builtin.text, builtin.name, "", {}));
    EXPECT_FALSE(builtin.title.empty()) << builtin.name;
  }
  EXPECT_NO_THROW(parse(template_scene));
}

TEST(Scene, NothingInAFileMakesItCrash) {
  // Every prefix of a scene, and a scene with each byte changed, is a scene or an error with a place.
  for (std::size_t length = 0; length < small.size(); ++length) error_of(small.substr(0, length));
  for (std::size_t at = 0; at < small.size(); ++at) {
    for (const char c : {'\0', '[', '}', ':', '-', '&', '*', '\xff', '\t'}) {
      std::string changed = small;
      changed[at] = c;
      error_of(changed);
    }
  }
}

}  // namespace
}  // namespace runner
