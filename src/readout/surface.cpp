// SPDX-License-Identifier: Apache-2.0
// The surface of a World: checks of its description.
#include <cmath>

#include "engine/surface_request.hpp"
#include "engine/text.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

using core::invalid;

Result<SurfaceMesh> WorldImpl::surface(const SurfaceDesc& d) {
  if (!d.wait)
    return invalid(
        "surface: wait: is false, but the mesh is brought to the host; ask surface_view(), or leave it true");
  SurfaceMesh mesh;
  const auto view = surface_view(d, &mesh);
  if (!view) return view.error();
  mesh.origin = view->origin;
  return mesh;
}

Status WorldImpl::check_surface(const SurfaceDesc& d, double cell) const {
  const double dx = desc.spacing;
  if (d.of != SurfaceOf::liquid && d.of != SurfaceOf::solids && d.of != SurfaceOf::body)
    return invalid("surface: of: is no SurfaceOf, got ", static_cast<int>(d.of));
  if (d.kernel != SurfaceKernel::isotropic && d.kernel != SurfaceKernel::anisotropic)
    return invalid("surface: kernel: is no SurfaceKernel, got ", static_cast<int>(d.kernel));
  if (!(cell >= dx / 16 && cell <= 2 * dx))
    return invalid("surface: cell: must be between 1/16 and 2 spacings (", dx / 16, " to ", 2 * dx,
                   " m), got ", d.cell, "; 0 is half a spacing");
  if (d.smoothing < 0 || d.smoothing > 100)
    return invalid("surface: smoothing: must be 0 to 100 passes, got ", d.smoothing);
  return d.of == SurfaceOf::body ? check_body("surface", d.body) : Status{};
}

Result<SurfaceView> WorldImpl::surface_view(const SurfaceDesc& d, SurfaceMesh* mesh) {
  const double dx = desc.spacing, cell = d.cell == automatic ? 0.5 * dx : d.cell;
  if (Status s = check_surface(d, cell); !s) return s.error();
  if (Status s = prepare(); !s) return s.error();
  SurfaceView view;
  view.backend = engine->backend();
  view.serial = mark_view(surface_view_, true);
  const core::FactSet needed = d.of == SurfaceOf::liquid ? core::fact_fluid : core::fact_solid;
  if ((facts_ & needed) == 0 && plan_changed_ && !halted_ &&
      !engine->host_captures())  // the first of it has come
    if (Status s = adapt(); !s) return s.error();
  const bool solids = (facts_ & core::fact_solid) != 0;
  if ((facts_ & needed) == 0) return view;
  core::SurfaceRequest q;
  q.of = d.of;
  q.body = d.of == SurfaceOf::body ? d.body.index + 1 : 0;
  q.cell = cell;
  q.spacing = dx;
  q.anisotropic = d.kernel == SurfaceKernel::anisotropic;
  q.solids = solids;
  q.closed = d.closed_at_solids;
  q.smoothing = d.smoothing;
  q.waits = d.wait;
  q.domain = desc.domain;
  q.domain.min = q.domain.min - origin_;
  q.domain.max = q.domain.max - origin_;
  auto halted = engine->surface(q, view, mesh);
  if (halted && *halted) {  // back to the last good state first
    fetch_state();
    halted = engine->surface(q, view, mesh);
  }
  if (!halted) return halted.error();
  view.origin += origin_;
  view.serial = surface_view_.serial;  // the engine has filled in the rest
  return view;
}

}  // namespace v0
}  // namespace meltsim
