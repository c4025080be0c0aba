// SPDX-License-Identifier: Apache-2.0
// Whether a view of the backend's memory still holds.
#include "description/validate.hpp"
#include "engine/text.hpp"
#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

using core::invalid;

/// The serial of a view that is made now; anew: whatever was made before has ended with it. The upper half names the World.
std::uint64_t WorldImpl::mark_view(Made& made, bool anew) {
  const bool same =
      made.serial != 0 && made.layout == layout_ && made.restored == restored_ && made.steps == steps;
  if (anew || !same) made = {(std::uint64_t{number_} << 32u) | ++views_, layout_, uploads_, restored_, steps};
  return made.serial;
}

namespace {
Error past(const char* since, const char* call) {
  return {ErrorCode::invalid_argument,
          core::text("check_view: view: is past its time: ", since, "; call ", call, "() again")};
}
}  // namespace

Status WorldImpl::check_view(const char* call, const Made& made, std::uint64_t serial) const {
  if (serial == 0)
    return invalid(
        "check_view: view: no call of a World has made it, or it is of a custom stage, with which it ends");
  if (static_cast<std::uint32_t>(serial >> 32u) != number_)
    return invalid("check_view: view: another World has made it; ask ", call, "() of this one");
  if (serial != made.serial) return past("a later one has taken its place", call);
  return {};
}

Status WorldImpl::check_view(const StageContext& view) const {
  const Made& made = state_view_;
  constexpr const char* call = "device_state";
  if (Status s = check_view(call, made, view.serial); !s) return s;
  if (made.steps != steps) return past("a step was taken", call);
  if (made.restored != restored_) return past("another state was loaded", call);
  if (dirty_ || made.layout != layout_)
    return past("something was added or removed, or the plan changed", call);
  return {};
}
Status WorldImpl::check_view(const RenderView& view) const {
  return check_view("render_view", render_view_, view.serial);
}
Status WorldImpl::check_view(const SurfaceView& view) const {
  constexpr const char* call = "surface_view";
  if (Status s = check_view(call, surface_view_, view.serial); !s) return s;
  if (surface_view_.uploads != uploads_) return past("something was added or restored", call);
  return {};
}

}  // namespace v0
}  // namespace meltsim
