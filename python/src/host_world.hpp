// SPDX-License-Identifier: Apache-2.0
// The World behind meltsim.World: guards against two threads and dangling arrays, names, frames for the replay.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>

#include "common.hpp"
#include "load_scene.hpp"
#include "show/replay.hpp"

namespace meltsim_python {

/// An object of a World. `world` is the serial number of the World it is of.
template <class Tag>
struct Named {
  std::uint64_t world = 0;
  meltsim::Handle<Tag> id;
  std::string name;
  /// Of a probe of a scene: its point of the World's probe, which may have others; -1: all of them.
  int point = -1;
};
using Material = Named<meltsim::MaterialTag>;
using Body = Named<meltsim::BodyTag>;
using Emitter = Named<meltsim::EmitterTag>;
using HeatRegion = Named<meltsim::HeatRegionTag>;
using ForceField = Named<meltsim::ForceFieldTag>;
using Probe = Named<meltsim::ProbeTag>;

class HostWorld;

/// A Python function that runs in every sub-step.
struct Stage {
  HostWorld* world = nullptr;
  std::string name;
  nb::object function;
  std::vector<std::string> writes;
};

class HostWorld {
 public:
  HostWorld(meltsim::World world, runner::Scene scene);
  HostWorld(const HostWorld&) = delete;
  ~HostWorld();
  /// At the end of Python: takes out the stages of all Worlds, but of those that another thread steps.
  static void release_all();

  /// The World, for one call of one thread.
  class Use {
   public:
    explicit Use(HostWorld& world, bool changes = false);
    ~Use() { host_.busy_ = false; }
    Use(const Use&) = delete;
    meltsim::World& operator*() const { return *host_.world_; }
    meltsim::World* operator->() const { return &*host_.world_; }

   private:
    HostWorld& host_;
  };

  void step(double seconds) {
    advance([seconds](meltsim::World& world) { return world.step(seconds); });
  }
  /// Takes steps while other Python threads run; Ctrl-C and what a stage raises end them.
  void advance(const std::function<meltsim::Status(meltsim::World&)>& steps);
  nb::object state();
  void add_stage(const std::string& name, nb::object function, const std::string& after,
                 std::vector<std::string> reads, std::vector<std::string> writes, bool recorded);
  void remove_stage(const std::string& name);
  void record();
  std::string page(const std::string& title) const;
  std::uint64_t frames() const { return frame_; }
  void clear_frames();
  void clear() { stages_.clear(); }
  /// Releases the World. What needs it is refused from then on.
  void close();
  bool closed() const { return !world_; }

  /// Whether it was not removed.
  template <class Tag>
  bool is_there(const Named<Tag>&) const {
    return true;
  }
  bool is_there(const Body& body) const {
    return std::find(removed.begin(), removed.end(), body.id) == removed.end();
  }
  template <class Tag>
  meltsim::Handle<Tag> resolve(const std::string& argument, const std::vector<Named<Tag>>& known,
                               nb::handle value, const char* kind) const;

  meltsim::World& unguarded();  ///< for calls that any thread may make
  std::uint64_t serial() const { return serial_; }

  std::vector<Material> materials;
  std::vector<Body> bodies;
  std::vector<meltsim::BodyId> removed;  ///< of the bodies, until compact()
  std::vector<Probe> probes;             ///< that there are
  /// Removed ones of a scene that are points of a probe of the World which others have.
  std::vector<Probe> unnamed;
  std::vector<Emitter> emitters;
  std::vector<HeatRegion> regions;
  std::vector<ForceField> fields;                          ///< that there are
  std::map<std::uint64_t, meltsim::ReadRequest> requests;  ///< open ones, by ticket
  runner::Scene scene;
  std::atomic<int> exported{0};              ///< arrays of the World's own memory that are alive
  std::atomic<int> packed{0};                ///< of render_view() that are
  std::atomic<std::uint64_t> packs{0};       ///< calls of render_view()
  std::atomic<int> surfaced{0};              ///< arrays of surface_view() that are alive
  std::atomic<std::uint64_t> generation{0};  ///< of the state: views of another one have expired
  std::vector<std::unique_ptr<Stage>>& stages() { return stages_; }

 private:
  static void run_stage(const meltsim::StageContext& context, void* stage);

  std::optional<meltsim::World> world_;
  std::atomic<bool> busy_{false};
  std::uint64_t serial_;
  std::vector<std::unique_ptr<Stage>> stages_;
  std::exception_ptr fault_;  ///< what a stage threw
  bool stale_interrupt_ = false;
  runner::Replay replay_;
  std::string stats_;
  std::uint64_t frame_ = 0, meltable_ = 0;
};

/// Views of the World's own memory: of the state between steps, or within a stage.
struct State {
  meltsim::StageContext context;
  nb::object owner;  ///< the World
  HostWorld* world = nullptr;
  std::uint64_t generation = 0;
  bool stage = false;
  std::vector<std::string> writes;  ///< what the stage may change
  bool writable(const char* channel) const {
    return std::find(writes.begin(), writes.end(), channel) != writes.end();
  }
  std::shared_ptr<bool> alive = std::make_shared<bool>(true);
};

/// Particles by id, as render_view() packed them.
struct RenderPack {
  meltsim::RenderView view;
  nb::object owner;  ///< the World
  HostWorld* world = nullptr;
  std::uint64_t pack = 0;  ///< which call it is of
};

/// A mesh that surface_view() made.
struct SurfacePack {
  meltsim::SurfaceView view;
  nb::object owner;  ///< the World
  HostWorld* world = nullptr;
};

/// What take() gave, with the World whose names it is told by.
struct HostReading {
  meltsim::Reading reading;
  meltsim::ReadRequest asked;
  nb::object owner;  ///< the World
  HostWorld* world = nullptr;
};

template <class Tag>
meltsim::Handle<Tag> HostWorld::resolve(const std::string& argument, const std::vector<Named<Tag>>& known,
                                        nb::handle value, const char* kind) const {
  if (nb::isinstance<Named<Tag>>(value)) {
    const auto& named = nb::cast<const Named<Tag>&>(value);
    if (named.world != serial_)
      refuse(argument + ": " + kind + " \"" + named.name + "\" belongs to another World; add it to this one");
    return named.id;
  }
  if (!PyUnicode_Check(value.ptr()))
    wrong_type(argument + ": expected " + (kind[0] == 'e' ? "an " : "a ") + kind +
               " of this World or its name, got " + shown(value));
  const std::string name = text(argument, value);
  std::string list;
  for (const Named<Tag>& named : known) {
    if (named.name == name) return named.id;
    if (is_there(named)) list += (list.empty() ? "" : ", ") + named.name;
  }
  refuse(argument + ": no " + kind + " is named \"" + name + "\"; there " +
         (list.empty() ? "are none" : "are: " + list));
}

}  // namespace meltsim_python
