// SPDX-License-Identifier: Apache-2.0
// Kinematic bodies that deform: meshes that the host moves, and their motion in a step.
#include <algorithm>
#include <cmath>
#include <utility>

#include "description/validate.hpp"
#include "engine/text.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

using core::invalid;

namespace {
Status check_vertices(const std::string& what, const std::vector<Vec3d>& vertices,
                      const std::vector<Vec3d>& velocities) {
  const auto check = [&what](const char* name, const std::vector<Vec3d>& values) -> Status {
    for (std::size_t i = 0; i < values.size(); ++i)
      if (!finite(values[i]))
        return invalid(what, name, "[", static_cast<std::uint64_t>(i), "]: must be finite, got ", values[i]);
    return {};
  };
  if (!velocities.empty() && velocities.size() != vertices.size())
    return invalid(what, "velocities: must be one per vertex, ", static_cast<std::uint64_t>(vertices.size()),
                   ", or none, got ", static_cast<std::uint64_t>(velocities.size()));
  if (Status s = check("vertices", vertices); !s) return s;
  return check("velocities", velocities);
}
}  // namespace

Status WorldImpl::update_mesh(BodyId id, const std::vector<Vec3d>& vertices,
                              const std::vector<Vec3d>& velocities) {
  if (Status s = check_body("update_mesh", id); !s) return s;
  BodyRecord& body = bodies_[id.index];
  const std::string what = "update_mesh: body \"" + body.desc.name + "\": ";
  if (!body.kinematic())
    return invalid(
        what,
        "motion: only the mesh of a kinematic body can be moved; build it with SolidDesc::motion kinematic");
  if (Status s = check_vertices(what, vertices, velocities); !s) return s;
  if (engine->host_captures())
    return invalid(
        what,
        "the World's stream is being captured into a graph, which cannot hold a mesh; end the capture first");
  std::shared_ptr<const core::MeshChords> chords = body.chords;
  if (!chords) {
    auto bound = bind_mesh(id.index, what);
    if (!bound) return bound.error();
    chords = std::move(*bound);
  }
  if (vertices.size() != chords->vertices())
    return invalid(
        what, "vertices: the mesh has ", static_cast<std::uint64_t>(chords->vertices()), " vertices, got ",
        static_cast<std::uint64_t>(vertices.size()),
        "; pass all of them in the order of TriangleMesh::vertices, its triangles stay what they are");
  PendingMesh& pending = meshes_[id.index];
  pending.points.resize(body.vertices);
  if (!deforms(id.index)) make_deformable(id.index);
  body.chords = chords;
  for (std::size_t k = 0; k < pending.points.size(); ++k) {
    pending.points[k].then = chords->at(k, vertices) - body.pivot;
    pending.points[k].velocity = velocities.empty() ? Vec3d{} : chords->at(k, velocities);
  }
  pending.set = true;
  return {};
}

/// How the particles of a body follow its mesh.
Result<std::shared_ptr<const core::MeshChords>> WorldImpl::bind_mesh(std::uint32_t index,
                                                                     const std::string& what) const {
  const BodyRecord& body = bodies_[index];
  const TriangleMesh mesh = mesh_of(body.desc.shape);
  if (mesh.indices.empty())
    return invalid(what,
                   "shape: it was not built from one mesh; build it from Shape::mesh(), which may be "
                   "transformed, but not be "
                   "part of another shape");
  if (body.desc.growth > 0)
    return invalid(what, "growth: sites around a body do not follow its mesh; build it with growth 0");
  const auto first = lattice_.vertex_coordinates.begin() + static_cast<std::ptrdiff_t>(body.first_vertex);
  const std::vector<Vec3i> sites(first, first + static_cast<std::ptrdiff_t>(body.vertices));
  auto chords = std::make_shared<core::MeshChords>();
  const std::size_t bound = core::bind_sites(mesh, lattice_origin(), desc.spacing, sites, *chords);
  if (bound == sites.size()) return std::shared_ptr<const core::MeshChords>(std::move(chords));
  const Vec3i& lost = sites[bound];
  return invalid(what, "shape: the mesh does not enclose the particle at ",
                 lattice_origin() + Vec3d{lost.x + 0.5, lost.y + 0.5, lost.z + 0.5} * desc.spacing,
                 " along any axis; close its holes");
}

/// Makes room for a body's points among those of others, in the order of bodies; they are where the body has them as built.
void WorldImpl::make_deformable(std::uint32_t body) {
  fetch_state();
  const BodyRecord& b = bodies_[body];
  std::vector<physics::MeshPoint> points(b.vertices);
  for (std::uint32_t k = 0; k < b.vertices; ++k) {
    points[k].first = points[k].then = rest_of(body, b.first_vertex + k, {});
    points[k].from = points[k].until = time;
  }
  std::uint32_t first = 0;
  for (std::uint32_t i = 0; i < body; ++i) first += deforms(i) ? bodies_[i].vertices : 0;
  state_.mesh_points.insert(state_.mesh_points.begin() + static_cast<std::ptrdiff_t>(first), points.begin(),
                            points.end());  // from here on nothing fails
  lattice_.rests[body].first_point = first;
  place_mesh_points();
  dirty_ = true;
}

/// Numbers the points of bodies that deform, those that have a first one.
void WorldImpl::place_mesh_points() {
  std::uint32_t at = 0;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    if (lattice_.rests[i].first_point == core::none) continue;
    lattice_.rests[i].first_point = at;
    at += bodies_[i].vertices;
  }
  lattice_.mesh_points = at;
}

/// Points of a deforming body on the device, or those that the planned step gives it.
const physics::MeshPoint* WorldImpl::mesh_points_of(std::uint32_t body) const {
  return state_.mesh_points.data() + lattice_.rests[body].first_point;
}

/// Moves the particles from their present positions, at constant velocity, to those of the mesh within a step of dt.
void WorldImpl::plan_mesh(std::uint32_t body, double dt) {
  const physics::MeshPoint* now = mesh_points_of(body);
  for (std::size_t k = 0; k < meshes_[body].points.size(); ++k) {
    physics::MeshPoint& p = meshes_[body].points[k];
    p.first = physics::mesh_point_at(now[k], time).position;
    p.from = time;
    p.until = time + dt;
  }
}

/// Motion of a body's particles relative to its pivot within the next dt. planned: that of update_mesh(), if it was called.
BodyExtent WorldImpl::extent_of(std::uint32_t body, double dt, bool planned) const {
  const BodyRecord& b = bodies_[body];
  BodyExtent e{0, b.reach, 0, b.rest_low, b.rest_high, time + dt, nullptr};
  if (!deforms(body)) return e;
  const physics::MeshPoint* points = e.points =
      planned && meshes_[body].set ? meshes_[body].points.data() : mesh_points_of(body);
  double speed2 = 0, reach2 = 0, later2 = 0;
  e.low = {infinity, infinity, infinity};
  e.high = -e.low;
  for (std::uint32_t k = 0; k < b.vertices; ++k) {
    const physics::RigidPoint now = physics::mesh_point_at(points[k], time),
                              end = physics::mesh_point_at(points[k], time + dt);
    speed2 = std::max(speed2, dot(now.velocity, now.velocity));
    later2 = std::max(later2, dot(end.velocity, end.velocity));
    reach2 = std::max({reach2, dot(now.position, now.position), dot(end.position, end.position)});
    e.low = {std::min(e.low.x, end.position.x), std::min(e.low.y, end.position.y),
             std::min(e.low.z, end.position.z)};
    e.high = {std::max(e.high.x, end.position.x), std::max(e.high.y, end.position.y),
              std::max(e.high.z, end.position.z)};
  }
  e.speed = std::sqrt(speed2);
  e.reach = std::sqrt(reach2);
  e.later = std::sqrt(later2);
  return e;
}

}  // namespace v0
}  // namespace meltsim
