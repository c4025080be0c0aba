// SPDX-License-Identifier: Apache-2.0
#include "show/usd_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstring>
#include <iterator>
#include <set>

#include "meltsim/particle_tag.hpp"

namespace runner {

namespace {

using meltsim::Vec3d;
using meltsim::Vec3f;
using Extent = std::optional<meltsim::Box>;

/// Nine digits bring a float back to the bit.
void put_number(std::string& to, double value) { fmt::format_to(std::back_inserter(to), "{:.9g}", value); }
void put_point(std::string& to, const Vec3d& p) {
  fmt::format_to(std::back_inserter(to), "({:.9g}, {:.9g}, {:.9g})", p.x, p.y, p.z);
}
void put_vector(std::string& to, const Vec3f& v) { put_point(to, meltsim::cast<double>(v)); }

/// Text of one of the three files. All have the same prims and attributes.
class Stage {
 public:
  enum class Kind { frame, clips, manifest };
  Stage(Kind kind, std::uint64_t frame) : kind_(kind), frame_(frame) {}

  bool is_frame() const { return kind_ == Kind::frame; }
  bool is_manifest() const { return kind_ == Kind::manifest; }
  std::string& text() { return text_; }

  /// `put(i)` appends item i of an array that changes from frame to frame; without values it is declared only.
  template <class Put>
  void array(const std::string& declaration, std::size_t count, const Put& put,
             const char* interpolation = nullptr) {
    declare(declaration, "", interpolation);
    if (!is_frame()) return;
    text_ += indent_ + declaration + ".timeSamples = {\n" + indent_ + "    " + std::to_string(frame_) + ": ";
    put_items(count, put);
    text_ += ",\n" + indent_ + "}\n";
  }
  /// What is the same in all frames. Value clips leave it to the file that joins them.
  void fixed(const std::string& declaration, const std::string& value, const char* interpolation = nullptr) {
    if (!is_manifest()) declare(declaration, " = " + value, interpolation);
  }
  void line(const std::string& content) { text_ += indent_ + content + "\n"; }
  void open(const std::string& head, const std::string& schema = "") {
    if (schema.empty() || is_manifest()) line(head);
    else line(head + " (\n" + indent_ + "    prepend apiSchemas = [\"" + schema + "\"]\n" + indent_ + ")");
    line("{");
    indent_ += "    ";
  }
  void close() {
    indent_.resize(indent_.size() - 4);
    line("}");
  }

 private:
  void declare(const std::string& declaration, const std::string& value, const char* interpolation) {
    text_ += indent_ + declaration + value;
    if (interpolation != nullptr)
      text_ += fmt::format(" (\n{0}    interpolation = \"{1}\"\n{0})", indent_, interpolation);
    text_ += "\n";
  }
  template <class Put>
  void put_items(std::size_t count, const Put& put) {
    text_ += "[";
    for (std::size_t i = 0; i < count; ++i) {
      if (i != 0) text_ += ", ";
      put(i);
    }
    text_ += "]";
  }

  Kind kind_;
  std::uint64_t frame_;
  std::string text_, indent_;
};

/// A box around both.
meltsim::Box around(const meltsim::Box& a, const meltsim::Box& b) {
  return {{std::min(a.min.x, b.min.x), std::min(a.min.y, b.min.y), std::min(a.min.z, b.min.z)},
          {std::max(a.max.x, b.max.x), std::max(a.max.y, b.max.y), std::max(a.max.z, b.max.z)}};
}

/// Of places, `place(i)` each, and so far around them; of none nothing.
template <class Place>
Extent bounds_of(std::size_t count, double margin, const Place& place) {
  if (count == 0) return {};
  meltsim::Box box{place(0), place(0)};
  for (std::size_t i = 1; i < count; ++i) box = around(box, {place(i), place(i)});
  const Vec3d m{margin, margin, margin};
  return meltsim::Box{box.min - m, box.max + m};
}

Extent bounds_of(const Mesh& mesh, const Vec3d& origin) {
  return bounds_of(mesh.position.size(), 0,
                   [&](std::size_t i) { return meltsim::cast<double>(mesh.position[i]) + origin; });
}

/// What readers want beside the points. Between two frames points stay and extents are interpolated: one that bounds the frame before as
/// well bounds what stays of it. Of nothing a point, since extents without numbers of their own (USD's empty range) have no middle.
void put_extent(Stage& stage, const Extent& now, const Extent& before, const Vec3d& origin) {
  meltsim::Box box{origin, origin};
  if (now && before) box = around(*now, *before);
  else if (now) box = *now;
  else if (before) box = *before;
  stage.array("float3[] extent", 2,
              [&](std::size_t i) { put_point(stage.text(), i == 0 ? box.min : box.max); });
}

/// A number of every vertex or particle. float for the others, int for what counts.
template <class Value>
void put_scalars(Stage& stage, const std::string& name, std::size_t count, const Value& value) {
  constexpr bool whole = std::is_integral_v<decltype(value(std::size_t{0}))>;
  stage.array((whole ? "int[] primvars:" : "float[] primvars:") + name, count,
              [&](std::size_t i) {
                if constexpr (whole) stage.text() += std::to_string(value(i));
                else put_number(stage.text(), static_cast<double>(value(i)));
              },
              "vertex");
}

/// What is dissolved, a column for each species. `columns[k]` has `count` numbers, or is missing.
void put_contents(Stage& stage, const UsdRun& run, std::size_t count,
                  const std::vector<std::vector<float>>& columns) {
  for (std::size_t k = 0; k < run.contents.size(); ++k) {
    const bool there = k < columns.size() && columns[k].size() == count;
    put_scalars(stage, run.contents[k], there ? count : 0, [&](std::size_t i) { return columns[k][i]; });
  }
}

void put_particles(Stage& stage, const UsdRun& run, const meltsim::ParticleFrame& p,
                   const UsdBounds& before) {
  const std::size_t n = p.id.size();
  std::string& text = stage.text();
  const auto place = [&](std::size_t i) { return meltsim::cast<double>(p.position[i]) + p.origin; };
  stage.open("def Points \"particles\"");
  put_extent(stage, bounds_of(n, 0.5 * run.spacing, place), before.particles, p.origin);
  stage.array("point3f[] points", n, [&](std::size_t i) { put_point(text, place(i)); });
  stage.array("vector3f[] velocities", n, [&](std::size_t i) { put_vector(text, p.velocity[i]); });
  stage.fixed("float[] widths", fmt::format("[{:.9g}]", run.spacing), "constant");
  stage.array("int64[] ids", n, [&](std::size_t i) { text += std::to_string(p.id[i]); });
  put_scalars(stage, "temperature", n, [&](std::size_t i) { return p.temperature[i]; });
  put_scalars(stage, "liquid_fraction", n, [&](std::size_t i) { return p.liquid_fraction[i]; });
  put_scalars(stage, "body", n, [&](std::size_t i) {
    return meltsim::is_solid(p.tag[i]) ? static_cast<int>(meltsim::body_of(p.tag[i])) - 1 : -1;
  });
  put_scalars(stage, "material", n, [&](std::size_t i) { return meltsim::material_of(p.tag[i]); });
  put_contents(stage, run, n, p.fractions);
  stage.close();
}

/// Names of prims are letters, digits and underscores, and differ from each other.
std::vector<std::string> prim_names(const PartLooks& looks) {
  std::vector<std::string> names;
  for (const PartLook& look : looks.all) {
    std::string name = look.name;
    for (char& c : name)
      if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
    if (name.empty() || std::isdigit(static_cast<unsigned char>(name[0])) != 0) name = "_" + name;
    while (std::find(names.begin(), names.end(), name) != names.end()) name += "_";
    names.push_back(name);
  }
  return names;
}

std::string binding_of(const std::string& material) {
  return fmt::format("rel material:binding = </meltsim/materials/{}>", material);
}

/// Triangles of a mesh in the order of its materials, and where those of each begin.
struct Faces {
  std::vector<std::uint32_t> corners;
  std::map<std::size_t, std::pair<std::size_t, std::size_t>> span;  ///< first and last + 1
};

Faces sorted_faces(const PartedMesh& parted) {
  Faces faces;
  for (const auto& [look, triangles] : parted.triangles) {
    const std::size_t first = faces.corners.size() / 3;
    faces.corners.insert(faces.corners.end(), triangles.begin(), triangles.end());
    faces.span[look] = {first, faces.corners.size() / 3};
  }
  return faces;
}

/// A material for the whole mesh, or one for each of its parts: all that it has in any frame.
void put_bindings(Stage& stage, const PartLooks& looks, const std::vector<std::size_t>& possible,
                  const Faces& faces) {
  const std::vector<std::string> names = prim_names(looks);
  if (possible.size() == 1) {
    if (!stage.is_manifest()) stage.line(binding_of(names[possible.front()]));
    return;
  }
  stage.fixed("uniform token subsetFamily:materialBind:familyType", "\"nonOverlapping\"");
  for (const std::size_t look : possible) {
    const auto found = faces.span.find(look);
    const auto [first, last] =
        found == faces.span.end() ? std::pair<std::size_t, std::size_t>{} : found->second;
    stage.open(fmt::format("def GeomSubset \"{}\"", names[look]), "MaterialBindingAPI");
    stage.fixed("uniform token elementType", "\"face\"");
    stage.fixed("uniform token familyName", "\"materialBind\"");
    stage.array("int[] indices", last - first,
                [&, from = first](std::size_t i) { stage.text() += std::to_string(from + i); });
    if (!stage.is_manifest()) stage.line(binding_of(names[look]));
    stage.close();
  }
}

bool all_opaque(const PartLooks& looks, const std::vector<std::size_t>& possible) {
  return std::all_of(possible.begin(), possible.end(),
                     [&](std::size_t look) { return looks.all[look].opacity >= 1; });
}

/// For readers that show no materials, and for materials of surfaces that have several.
void put_colors(Stage& stage, const PartLooks& looks, const std::vector<std::size_t>& possible,
                const PartedMesh& parted) {
  const PartLook& only = looks.all[possible.front()];
  std::string& text = stage.text();
  if (possible.size() == 1 && !only.by_vertex) {
    stage.fixed("color3f[] primvars:displayColor",
                fmt::format("[({:.4g}, {:.4g}, {:.4g})]", only.color[0], only.color[1], only.color[2]),
                "constant");
  } else {
    stage.array(
        "color3f[] primvars:displayColor", parted.mesh.color.size(),
        [&](std::size_t i) {
          const Vec3f& c = parted.mesh.color[i];
          fmt::format_to(std::back_inserter(text), "({:.4g}, {:.4g}, {:.4g})", c.x, c.y, c.z);
        },
        "vertex");
  }
  if (all_opaque(looks, possible)) return;
  if (possible.size() == 1) {
    stage.fixed("float[] primvars:displayOpacity", fmt::format("[{:g}]", only.opacity), "constant");
    return;
  }
  std::vector<double> opacity(parted.mesh.position.size(), 1);
  for (const auto& [look, triangles] : parted.triangles)
    for (const std::uint32_t v : triangles) opacity[v] = std::min(opacity[v], looks.all[look].opacity);
  stage.array(
      "float[] primvars:displayOpacity", opacity.size(), [&](std::size_t i) { put_number(text, opacity[i]); },
      "vertex");
}

void put_mesh(Stage& stage, const UsdRun& run, const char* name, const PartedMesh& parted,
              const std::vector<std::size_t>& possible, const Vec3d& origin, const Extent& before) {
  const Mesh& mesh = parted.mesh;
  const Faces faces = sorted_faces(parted);
  const std::size_t n = mesh.position.size();
  std::string& text = stage.text();
  const auto place = [&](std::size_t i) { return meltsim::cast<double>(mesh.position[i]) + origin; };
  stage.open(fmt::format("def Mesh \"{}\"", name), "MaterialBindingAPI");
  stage.fixed("uniform token subdivisionScheme", "\"none\"");
  put_extent(stage, bounds_of(mesh, origin), before, origin);
  stage.array("int[] faceVertexCounts", faces.corners.size() / 3, [&](std::size_t) { text += "3"; });
  stage.array("int[] faceVertexIndices", faces.corners.size(),
              [&](std::size_t i) { text += std::to_string(faces.corners[i]); });
  stage.array("point3f[] points", n, [&](std::size_t i) { put_point(text, place(i)); });
  stage.array(
      "normal3f[] normals", n, [&](std::size_t i) { put_vector(text, mesh.normal[i]); }, "vertex");
  put_colors(stage, run.looks, possible, parted);
  put_scalars(stage, "temperature", n, [&](std::size_t i) { return mesh.temperature[i]; });
  put_scalars(stage, "liquid_fraction", mesh.liquid_fraction.size(),
              [&](std::size_t i) { return mesh.liquid_fraction[i]; });
  put_scalars(stage, "body", n, [&](std::size_t i) { return static_cast<int>(mesh.body[i]) - 1; });
  put_scalars(stage, "material", n, [&](std::size_t i) { return mesh.material[i]; });
  if (name == std::string("liquid")) put_contents(stage, run, n, mesh.contents);
  put_bindings(stage, run.looks, possible, faces);
  stage.close();
}

/// An input of a material: `value`, or what the vertices have for it, which then is its fallback.
struct Input {
  const char *name, *type, *primvar, *reader;
  std::string value;
  bool by_vertex;
};

void put_input(Stage& stage, const Input& input, const std::string& path) {
  if (input.by_vertex)
    stage.line(fmt::format("{} inputs:{}.connect = <{}/{}.outputs:result>", input.type, input.name, path,
                           input.primvar));
  else stage.line(fmt::format("{} inputs:{} = {}", input.type, input.name, input.value));
}

void put_reader(Stage& stage, const Input& input) {
  if (!input.by_vertex) return;
  stage.open(fmt::format("def Shader \"{}\"", input.primvar));
  stage.line(fmt::format("uniform token info:id = \"UsdPrimvarReader_{}\"", input.reader));
  stage.line(fmt::format("{} inputs:fallback = {}", input.reader, input.value));
  stage.line(fmt::format("string inputs:varname = \"{}\"", input.primvar));
  stage.line(fmt::format("{} outputs:result", input.reader));
  stage.close();
}

/// Where a surface has several materials, each takes the colour of the vertices: readers that do not follow the parts from frame to
/// frame, as Blender does not, show the right colours then.
void put_material(Stage& stage, const PartLooks& looks, std::size_t number, const std::string& name) {
  const PartLook& look = looks.all[number];
  const std::string path = "/meltsim/materials/" + name;
  Input color{"diffuseColor", "color3f", "displayColor", "float3", "", look.by_vertex};
  Input opacity{"opacity", "float", "displayOpacity", "float", fmt::format("{:g}", look.opacity), false};
  color.value = fmt::format("({:.4g}, {:.4g}, {:.4g})", look.color[0], look.color[1], look.color[2]);
  for (const std::vector<std::size_t>* surface : {&looks.liquid, &looks.solid}) {
    if (surface->size() == 1 || std::count(surface->begin(), surface->end(), number) == 0) continue;
    color.by_vertex = true;
    if (!all_opaque(looks, *surface)) opacity.by_vertex = true;
  }
  stage.open(fmt::format("def Material \"{}\"", name));
  stage.line(fmt::format("token outputs:surface.connect = <{}/surface.outputs:surface>", path));
  stage.open("def Shader \"surface\"");
  stage.line("uniform token info:id = \"UsdPreviewSurface\"");
  put_input(stage, color, path);
  if (look.clear) stage.line(fmt::format("float inputs:ior = {:g}", water_ior));
  put_input(stage, opacity, path);
  stage.line(fmt::format("float inputs:roughness = {:g}", look.roughness));
  stage.line("token outputs:surface");
  stage.close();
  put_reader(stage, color);
  put_reader(stage, opacity);
  stage.close();
}

void put_materials(Stage& stage, const PartLooks& looks) {
  const std::vector<std::string> names = prim_names(looks);
  stage.open("def Scope \"materials\"");
  for (std::size_t i = 0; i < looks.all.size(); ++i) put_material(stage, looks, i, names[i]);
  stage.close();
}

/// USD mixes arrays of two frames at times between them where they are equally long, and two surfaces have different triangles: even frames
/// have an even number of vertices and odd ones an odd number, by a vertex without a triangle where needed.
PartedMesh unlike_next_frame(PartedMesh parted, std::uint64_t frame) {
  Mesh& mesh = parted.mesh;
  if (mesh.position.empty() || mesh.position.size() % 2 == frame % 2) return parted;
  const auto repeat = [](auto& values) {
    if (!values.empty()) values.push_back(values.back());
  };
  repeat(mesh.position);
  repeat(mesh.normal);
  repeat(mesh.temperature);
  repeat(mesh.liquid_fraction);
  repeat(mesh.body);
  repeat(mesh.material);
  repeat(mesh.color);
  for (std::vector<float>& content : mesh.contents) repeat(content);
  return parted;
}

/// Of the whole layer. A time code is the number of a frame.
void put_head(Stage& stage, const UsdRun& run, std::uint64_t first, std::uint64_t last,
              const std::string& more) {
  stage.text() += fmt::format(
      "#usda 1.0\n(\n    customLayerData = {{\n{}        string units = \"m, degrees Celsius\"\n    }}\n"
      "    defaultPrim = \"meltsim\"\n    endTimeCode = {}\n    framesPerSecond = {:.9g}\n"
      "    metersPerUnit = 1\n    startTimeCode = {}\n    timeCodesPerSecond = {:.9g}\n"
      "    upAxis = \"{}\"\n)\n\n",
      more, last, run.fps, first, run.fps, is_along(run.up, {0, 0, 1}) ? "Z" : "Y");
}

void put_turn(Stage& stage, const Vec3d& up) {
  if (stage.is_manifest() || is_along(up, {0, 0, 1}) || is_along(up, {0, 1, 0})) return;
  const std::array<double, 4> turn = turn_upright(up);
  stage.line(fmt::format("quatf xformOp:orient = ({3:.9g}, {0:.9g}, {1:.9g}, {2:.9g})", turn[0], turn[1],
                         turn[2], turn[3]));
  stage.line("uniform token[] xformOpOrder = [\"xformOp:orient\"]");
}

void put_prims(Stage& stage, const UsdRun& run, std::uint64_t frame, const meltsim::ParticleFrame& particles,
               const FrameShapes& shapes, const UsdBounds& before) {
  put_turn(stage, run.up);
  if (!stage.is_manifest()) put_materials(stage, run.looks);
  put_particles(stage, run, particles, before);
  put_mesh(stage, run, "liquid", unlike_next_frame(liquid_parts(shapes, run.looks), frame), run.looks.liquid,
           shapes.origin, before.liquid);
  put_mesh(stage, run, "solid", unlike_next_frame(solid_parts(shapes, run.looks), frame), run.looks.solid,
           shapes.origin, before.solid);
}

/// The extent of a prim, which begins with `head`, in the text of a frame.
Extent extent_in(const std::string& text, const std::string& head) {
  const std::size_t prim = text.find(head), extent = text.find("float3[] extent.timeSamples", prim);
  const std::size_t from = text.find("[(", extent == std::string::npos ? prim : extent);
  if (prim == std::string::npos || extent == std::string::npos || from == std::string::npos) return {};
  meltsim::Box b;
  const char *at = text.c_str() + from, *const end = text.c_str() + text.size();
  for (double* number : {&b.min.x, &b.min.y, &b.min.z, &b.max.x, &b.max.y, &b.max.z}) {
    while (at != end && std::strchr("[(,) ", *at) != nullptr) ++at;
    const auto read = std::from_chars(at, end, *number);  // whatever the host's locale is
    if (read.ec != std::errc()) return {};
    at = read.ptr;
  }
  return b;
}

}  // namespace

UsdBounds usd_bounds(const UsdRun& run, const meltsim::ParticleFrame& p, const FrameShapes& shapes) {
  const auto place = [&](std::size_t i) { return meltsim::cast<double>(p.position[i]) + p.origin; };
  return {bounds_of(p.id.size(), 0.5 * run.spacing, place), bounds_of(shapes.liquid, shapes.origin),
          bounds_of(shapes.solid, shapes.origin)};
}

UsdBounds usd_bounds_in(const std::string& text) {
  return {extent_in(text, "def Points \"particles\""), extent_in(text, "def Mesh \"liquid\""),
          extent_in(text, "def Mesh \"solid\"")};
}

std::string usd_text(const UsdRun& run, std::uint64_t frame, double time,
                     const meltsim::ParticleFrame& particles, const FrameShapes& shapes,
                     const UsdBounds& before) {
  Stage stage(Stage::Kind::frame, frame);
  put_head(stage, run, frame, frame, fmt::format("        double time_s = {:.9g}\n", time));
  stage.open("def Xform \"meltsim\"");
  put_prims(stage, run, frame, particles, shapes, before);
  stage.close();
  return std::move(stage.text());
}

std::string usd_manifest(const UsdRun& run) {
  Stage stage(Stage::Kind::manifest, 0);
  put_head(stage, run, 0, 0, "");
  stage.open("def Xform \"meltsim\"");
  put_prims(stage, run, 0, {}, {}, {});
  stage.close();
  return std::move(stage.text());
}

std::string usd_clips(const UsdRun& run, std::uint64_t first, std::uint64_t last) {
  Stage stage(Stage::Kind::clips, 0);
  put_head(stage, run, first, last, "");
  stage.open(
      fmt::format("def Xform \"meltsim\" (\n    clips = {{\n        dictionary default = {{\n"
                  "            asset manifestAssetPath = @./{}@\n            string primPath = \"/meltsim\"\n"
                  "            string templateAssetPath = \"./frames/scene.#####.usda\"\n"
                  "            double templateEndTime = {}\n            double templateStartTime = {}\n"
                  "            double templateStride = 1\n        }}\n    }}\n)",
                  usd_manifest_file, last, first));
  put_prims(stage, run, 0, {}, {}, {});
  stage.close();
  return std::move(stage.text());
}

std::string usd_frame_file(std::uint64_t frame) { return fmt::format("frames/scene.{:05}.usda", frame); }

}  // namespace runner
