// SPDX-License-Identifier: Apache-2.0
// A triangle mesh as a solid. Faces are half open in the sense of the box: the points sampled are moved by a
// hair towards +x, +y, +z, so that an axis-aligned mesh and the box of its corners hold the same sites.
#include "shape/box_ops.hpp"
#include "shape/mesh_raster.hpp"
#include "shape/mesh_shells.hpp"
#include "shape/shape_check.hpp"
#include "shape/shape_primitives.hpp"
#include "shape/shape_round.hpp"

namespace meltsim {
inline namespace v0 {
namespace {

Status check_mesh(const TriangleMesh& mesh) {
  if (mesh.indices.empty()) return refuse_shape("mesh.indices is empty; give at least one triangle");
  if (mesh.indices.size() % 3 != 0)
    return refuse_shape("mesh.indices has " + std::to_string(mesh.indices.size()) +
                        " entries but needs three per triangle");
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Vec3d v = mesh.vertices[i];
    // The name is only put together for a vertex at fault: there may be millions.
    if (finite(v) && check_point({}, v)) continue;
    return check_point("mesh.vertices[" + std::to_string(i) + "]", v);
  }
  for (std::size_t i = 0; i < mesh.indices.size(); ++i)
    if (mesh.indices[i] >= mesh.vertices.size())
      return refuse_shape("mesh.indices[" + std::to_string(i) + "] is " + std::to_string(mesh.indices[i]) +
                          " but must be less than the " + std::to_string(mesh.vertices.size()) + " vertices");
  return {};
}

class MeshNode final : public ShapeNode {
 public:
  explicit MeshNode(TriangleMesh mesh) : mesh_(std::move(mesh)), status_(check_mesh(mesh_)) {
    if (!status_) return;
    for (const std::uint32_t i : mesh_.indices) grow(bounds_, mesh_.vertices[i]);
    const double tie = tie_width(magnitude(bounds_.max - bounds_.min),
                                 maximum(magnitude(bounds_.min), magnitude(bounds_.max)));
    nudge_ = {tie, tie, tie};
    turns_ = triangle_turns(mesh_);
  }

  bool contains(Vec3d p) const override {
    const Vec3d q = p + nudge_;
    const Box& b = bounds_;
    if (!status_ || q.x < b.min.x || q.y < b.min.y || q.z < b.min.z || q.x > b.max.x || q.y > b.max.y ||
        q.z > b.max.z)
      return false;
    return inside_of(mesh_, turns_, q);
  }

  Box bounds(const Affine& to_world) const override {
    Box out = empty_box();
    if (status_)
      for (const std::uint32_t i : mesh_.indices) grow(out, to_world(mesh_.vertices[i]));
    return out;
  }

  Status validate() const override { return status_; }

  void fill(const Lattice& lattice, SiteMask& mask) const override {
    fill_inside(mesh_, turns_, nudge_, lattice, mask);
  }

  bool holds_mesh() const override { return true; }

  bool mesh(const Affine& to_world, TriangleMesh& out) const override {
    if (!status_) return false;
    out = mesh_;
    for (Vec3d& v : out.vertices) v = to_world(v);
    return true;
  }

 private:
  TriangleMesh mesh_;
  std::vector<std::int8_t> turns_;
  Status status_;
  Box bounds_ = empty_box();
  Vec3d nudge_;
};

}  // namespace

ShapePtr make_mesh(TriangleMesh mesh) { return std::make_shared<MeshNode>(std::move(mesh)); }

}  // namespace v0
}  // namespace meltsim
