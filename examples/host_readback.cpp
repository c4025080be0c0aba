// SPDX-License-Identifier: Apache-2.0
// What a host with its own renderer does: steps the world at the frame rate and copies the particles out.
// Writes the last frame as a CSV file (argument 1, default particles.csv).
#include <cstdio>

#include "meltsim/meltsim.hpp"

int main(int argc, char** argv) {
  using namespace meltsim;
  const char* path = argc > 1 ? argv[1] : "particles.csv";
  const auto fail = [](const Error& e) {
    std::fprintf(stderr, "%s\n", e.message.c_str());
    return 1;
  };

  WorldDesc desc;
  desc.spacing = 0.05;
  desc.domain.bounded = true;
  desc.domain.max = {1, 1, 0.5};
  auto world = World::create(desc);
  if (!world) return fail(world.error());

  auto water = world->add_material({});
  if (!water) return fail(water.error());

  // A column that collapses. Nothing here is solid or has another temperature, so the plan holds no
  // shape-matching, melting or heat stage and their buffers do not exist.
  FluidDesc column;
  column.shape = Shape::box({0, 0, 0}, {0.3, 0.6, 0.5});
  column.material = *water;
  if (auto added = world->add_fluid(column); !added) return fail(added.error());
  if (Status s = world->prepare(); !s) return fail(s.error());  // allocate now, not in the first frame
  std::printf("%s\n", world->plan().to_string().c_str());

  for (int frame = 0; frame < 10; ++frame)
    if (Status s = world->step(1.0 / 50); !s) return fail(s.error());

  // Reading back waits for the steps. Arrays are parallel and sorted by id, so row k is the same particle in
  // every frame, although the library reorders its own storage.
  auto data = world->particles();
  if (!data) return fail(data.error());

  std::FILE* file = std::fopen(path, "w");
  if (!file) return fail({ErrorCode::invalid_argument, std::string("cannot write ") + path});
  std::fprintf(file, "id,x,y,z,vx,vy,vz,temperature,liquid\n");
  for (std::size_t i = 0; i < data->id.size(); ++i) {
    const Vec3d x = data->position[i], v = data->velocity[i];
    std::fprintf(file, "%u,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%d\n", data->id[i], x.x, x.y, x.z, v.x, v.y,
                 v.z, data->temperature[i], is_fluid(data->tag[i]) ? 1 : 0);
  }
  std::fclose(file);
  std::printf("%zu particles written to %s\n", data->id.size(), path);
  return 0;
}
