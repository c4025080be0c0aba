// SPDX-License-Identifier: Apache-2.0
#include "modules/engine.hpp"

namespace modules_test {

void add_body(core::SceneLattice& l, core::SceneState& s, const core::SceneConstants& c,
              const std::vector<Vec3i>& points, int half_width, const std::vector<Vec3i>& free) {
  Vec3i lo = points.front(), hi = points.front();
  for (const auto* list : {&points, &free})
    for (const Vec3i& p : *list) {
      lo = {std::min(lo.x, p.x), std::min(lo.y, p.y), std::min(lo.z, p.z)};
      hi = {std::max(hi.x, p.x), std::max(hi.y, p.y), std::max(hi.z, p.z)};
    }
  const int pad = std::max(1, half_width);  // no look-up within a region leaves the box
  const auto nx = static_cast<std::uint32_t>(hi.x - lo.x + 1 + 2 * pad);
  const auto ny = static_cast<std::uint32_t>(hi.y - lo.y + 1 + 2 * pad);
  const auto nz = static_cast<std::uint32_t>(hi.z - lo.z + 1 + 2 * pad);
  core::BodyRow row;
  row.stride_y = nx;
  row.stride_z = nx * ny;
  row.region_half_width = half_width;
  const auto base = static_cast<std::uint32_t>(l.site_vertex.size());
  const auto body = static_cast<std::uint32_t>(l.bodies.size());
  l.site_vertex.resize(base + nx * ny * nz, core::none);
  const auto first = static_cast<std::uint32_t>(l.vertex_site.size());
  const auto site_of = [&](const Vec3i& p) {
    return base + static_cast<std::uint32_t>(p.x - lo.x + pad) +
           static_cast<std::uint32_t>(p.y - lo.y + pad) * row.stride_y +
           static_cast<std::uint32_t>(p.z - lo.z + pad) * row.stride_z;
  };
  for (const Vec3i& p : points) {
    const auto v = static_cast<std::uint32_t>(l.vertex_site.size());
    const std::uint32_t site = site_of(p);
    l.site_vertex[site] = v;
    const std::uint32_t tag = 1u | tag_solid | ((body + 1) << tag_body_shift);
    const std::uint32_t id = add_particle(s, c, Vec3d{p.x + 0.5, p.y + 0.5, p.z + 0.5} * c.spacing, tag);
    s.vertex_of_id[id] = v;
    s.vertex_state.push_back(1);
    s.vertex_piece.push_back(first);
    s.region_rotation.push_back({});
    s.contact_slip.push_back({});
    s.vertex_id.push_back(id);
    l.vertex_site.push_back(site);
    l.vertex_body.push_back(body);
    l.contact_shape.push_back({0, 0, 0, 0.5f});
    l.vertex_coordinates.push_back(p);
  }
  l.bodies.push_back(row);
  l.max_half_width = std::max(l.max_half_width, half_width);
  for (std::uint32_t v = first; v < l.vertex_site.size(); ++v) {
    std::uint32_t direct = 0;
    for (int bit = 0; bit < 27; ++bit)
      direct +=
          l.site_vertex[core::site_at(l.vertex_site[v], row, bit % 3 - 1, bit / 3 % 3 - 1, bit / 9 - 1)] !=
          core::none;
    if (direct < 27) s.tag[s.vertex_id[v]] |= tag_surface;
  }
  for (const Vec3i& p : free) {
    const auto v = static_cast<std::uint32_t>(l.vertex_site.size());
    l.site_vertex[site_of(p)] = v;
    l.vertex_site.push_back(site_of(p));
    l.vertex_body.push_back(body);
    l.contact_shape.push_back({0, 0, 0, 0.5f});
    l.vertex_coordinates.push_back(p);
    s.vertex_id.push_back(core::none);
    s.vertex_state.push_back(0);
    s.vertex_piece.push_back(v);
    s.region_rotation.push_back({});
  }
}

}  // namespace modules_test
