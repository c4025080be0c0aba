/* SPDX-License-Identifier: Apache-2.0
 * A host in C99 with a physics engine of its own, of one ball: pose and twist go to a proxy, the impulses of a frame come back.
 * The ball is dropped into water and floats. Prints its height; ends with 1 and the library's text on an error. */
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
  const double pool_max[3] = {1, 0.5, 1}, zero[3] = {0, 0, 0}, center[3] = {0.5, 0.75, 0.5};
  const double radius = 0.2, mass = 0.4 * 1000 * 4.18879 * 0.008; /* 0.4 of the density of water [kg] */
  const double dt = 1.0 / 60, gravity = -9.81;
  meltsim_world_desc desc;
  meltsim_material_desc water, wood;
  meltsim_fluid_desc pool;
  meltsim_solid_desc ball;
  meltsim_proxy_state state;
  meltsim_world* world = NULL;
  meltsim_shape *liquid = NULL, *sphere = NULL;
  meltsim_id water_id, wood_id, ball_id;
  int frame, k;

  meltsim_world_desc_init(&desc);
  desc.spacing = 0.0625; /* [m] */
  desc.bounded = 1;
  desc.heat_model = MELTSIM_HEAT_NONE;
  for (k = 0; k < 3; ++k) desc.domain_max[k] = k == 1 ? 1.5 : 1;
  TRY(meltsim_world_create(&desc, &world));
  meltsim_material_desc_init(&water);
  TRY(meltsim_world_add_material(world, &water, &water_id));
  meltsim_material_desc_init(&wood);
  wood.name = "wood";
  TRY(meltsim_world_add_material(world, &wood, &wood_id));

  TRY(meltsim_shape_box(zero, pool_max, &liquid));
  meltsim_fluid_desc_init(&pool);
  pool.shape = liquid;
  pool.material = water_id;
  TRY(meltsim_world_add_fluid(world, &pool, NULL));
  TRY(meltsim_shape_sphere(center, radius, &sphere));
  meltsim_solid_desc_init(&ball);
  ball.shape = sphere;
  ball.material = wood_id;
  ball.motion = MELTSIM_MOTION_PROXY;
  ball.mass = mass;
  ball.has_pivot = 1;
  for (k = 0; k < 3; ++k) ball.pivot[k] = center[k];
  ball.inertia[0] = ball.inertia[4] = ball.inertia[8] = 0.4 * mass * radius * radius;
  TRY(meltsim_world_add_solid(world, &ball, &ball_id));
  meltsim_shape_destroy(liquid);
  meltsim_shape_destroy(sphere);

  meltsim_proxy_state_init(&state);
  for (k = 0; k < 3; ++k) state.position[k] = center[k];
  for (frame = 1; frame <= 180; ++frame) {
    meltsim_body_forces on;
    size_t count = 0;
    TRY(meltsim_world_set_proxy(world, ball_id, &state));
    TRY(meltsim_world_step(world, dt));
    TRY(meltsim_world_take_forces(world, &on, sizeof on, 1, &count));
    /* The host's engine: its own gravity, the water's impulses. A ball looks the same however it has turned. */
    for (k = 0; k < 3; ++k) {
      state.velocity[k] += on.impulse[k] / mass + (k == 1 ? gravity * dt : 0);
      state.angular_velocity[k] += on.angular_impulse[k] / ball.inertia[0];
      state.position[k] += state.velocity[k] * dt;
      state.orientation[k + 1] =
          on.orientation[k + 1]; /* that of the proxy, which has turned as its spin says */
    }
    state.orientation[0] = on.orientation[0];
    if (frame % 30 == 0)
      printf("t = %.1f s: ball at %.3f m, %+.2f m/s, carried by %.0f N of %.0f N\n", frame * dt,
             state.position[1], state.velocity[1], on.pressure[1] / on.seconds, -mass * gravity);
  }
  meltsim_world_destroy(world);
  return 0;
}
