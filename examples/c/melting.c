/* SPDX-License-Identifier: Apache-2.0
 * A host in C99: a block of ice in warm water. Prints what has melted; ends with 1 and the library's text on an error. */
#include <stdio.h>

#include "meltsim/meltsim.h"

/* The first error ends the program; the text says what to do. */
#define TRY(call)                                    \
  do {                                               \
    if ((call) != MELTSIM_OK) {                      \
      fprintf(stderr, "%s\n", meltsim_error_text()); \
      return 1;                                      \
    }                                                \
  } while (0)

int main(void) {
  const double pool_min[3] = {0, 0, 0}, pool_max[3] = {1, 0.3, 1};
  const double block_min[3] = {0.3, 0.35, 0.3}, block_max[3] = {0.7, 0.65, 0.7};
  meltsim_world_desc desc;
  meltsim_material_desc water, ice;
  meltsim_fluid_desc pool;
  meltsim_solid_desc block;
  meltsim_world* world = NULL;
  meltsim_shape *liquid = NULL, *solid = NULL;
  meltsim_id water_id, ice_id;
  meltsim_report report = {.size = sizeof report};
  meltsim_totals before = {.size = sizeof before}, after = {.size = sizeof after};
  int frame;

  meltsim_world_desc_init(&desc);
  desc.spacing = 0.1; /* [m] */
  desc.bounded = 1;
  desc.domain_max[0] = desc.domain_max[1] = desc.domain_max[2] = 1;
  desc.heat_time_scale = 5e5; /* a time lapse: melting takes hours */
  TRY(meltsim_world_create(&desc, &world));

  meltsim_material_desc_init(&water);
  TRY(meltsim_world_add_material(world, &water, &water_id));
  meltsim_material_desc_init(&ice);
  ice.name = "ice";
  ice.density = 917;
  ice.melting_point = 0; /* [degrees Celsius] */
  ice.latent_heat = 3.34e5;
  ice.melts_into = water_id;
  TRY(meltsim_world_add_material(world, &ice, &ice_id));

  TRY(meltsim_shape_box(pool_min, pool_max, &liquid));
  meltsim_fluid_desc_init(&pool);
  pool.shape = liquid;
  pool.material = water_id;
  pool.temperature = 60;
  TRY(meltsim_world_add_fluid(world, &pool, NULL));
  TRY(meltsim_shape_box(block_min, block_max, &solid));
  meltsim_solid_desc_init(&block);
  block.shape = solid;
  block.material = ice_id;
  block.temperature = -5;
  TRY(meltsim_world_add_solid(world, &block, NULL));
  meltsim_shape_destroy(liquid);
  meltsim_shape_destroy(solid);

  TRY(meltsim_world_totals(world, &before));
  for (frame = 0; frame < 25; ++frame) TRY(meltsim_world_step(world, 0.04));
  TRY(meltsim_world_synchronize(world, &report));
  TRY(meltsim_world_totals(world, &after));
  printf("t = %.3f s, %llu particles melted, heat %.6g J before and %.6g J after\n", report.time,
         (unsigned long long)report.melted, before.thermal, after.thermal);
  meltsim_world_destroy(world);
  return 0;
}
