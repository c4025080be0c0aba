// SPDX-License-Identifier: Apache-2.0
// Other bodies in place of a World's, for as long as they are checked or for good.
#pragma once

#include <utility>
#include <vector>

#include "world/world_impl.hpp"

namespace meltsim {
inline namespace v0 {

/// Puts the World's bodies aside; they come back unless stay() is called.
class WorldImpl::OtherBodies {
 public:
  OtherBodies(WorldImpl& world, Vec3d origin) : world_(world), origin_(origin) { change_places(); }
  ~OtherBodies() {
    if (!stay_) change_places();
  }
  OtherBodies(const OtherBodies&) = delete;
  OtherBodies& operator=(const OtherBodies&) = delete;

  Status come_back(const std::vector<StoredBody>& stored) {
    const std::size_t n = stored.size();
    world_.bodies_.resize(n);
    world_.lattice_.bodies.resize(n);
    world_.lattice_.rests.resize(n);
    world_.motions_.resize(n);
    world_.meshes_.resize(n);
    world_.proxies_.resize(n);
    for (const StoredBody& body : stored)
      if (Status s = world_.come_back(body); !s) return s;
    return {};
  }
  void stay() { stay_ = true; }

 private:
  void change_places() noexcept {
    using std::swap;
    swap(bodies_, world_.bodies_);
    swap(names_, world_.body_names_);
    swap(lattice_, world_.lattice_);
    swap(motions_, world_.motions_);
    swap(meshes_, world_.meshes_);
    swap(proxies_, world_.proxies_);
    swap(built_, world_.solids_built_);
    swap(state_, world_.state_);
    swap(origin_, world_.origin_);
    swap(number_, world_.body_number_);
  }

  WorldImpl& world_;
  bool stay_ = false;
  std::vector<BodyRecord> bodies_;
  std::unordered_set<std::string> names_;
  core::SceneLattice lattice_;
  std::vector<std::optional<BodyMotion>> motions_;
  std::vector<PendingMesh> meshes_;
  std::vector<std::optional<ProxyState>> proxies_;
  std::uint64_t built_ = 0;
  core::SceneState state_;  ///< vertices of the lattice
  Vec3d origin_;
  std::uint32_t number_ = next_number();
};

}  // namespace v0
}  // namespace meltsim
