// SPDX-License-Identifier: Apache-2.0
#include "particle_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <type_traits>
#include <utility>

#include "files.hpp"

namespace runner {

namespace {

template <class T>
void append(std::string& to, T value) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  to.append(bytes, sizeof(T));
}

/// The arrays of a VTP file, each behind its length, and the XML that points at them.
class VtpArrays {
 public:
  explicit VtpArrays(std::size_t bytes) { data_.reserve(bytes); }
  template <class T, class Get>
  void add(const char* type, const char* name, int components, std::size_t count, Get get) {
    xml_ += fmt::format(
        "        <DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" "
        "format=\"appended\" offset=\"{}\"/>\n",
        type, name, components, data_.size());
    append<std::uint64_t>(data_, count * static_cast<std::size_t>(components) * sizeof(T));
    T part[3 * part_rows];
    for (std::size_t done = 0; done < count; done += part_rows) {
      const std::size_t rows = std::min(part_rows, count - done);
      T* to = part;
      for (std::size_t i = done; i < done + rows; ++i)
        for (int c = 0; c < components; ++c) *to++ = get(i, c);
      data_.append(reinterpret_cast<const char*>(part), static_cast<std::size_t>(to - part) * sizeof(T));
    }
  }
  std::string take_xml() { return std::exchange(xml_, {}); }
  std::string take_data() { return std::move(data_); }

 private:
  static constexpr std::size_t part_rows = 512;  ///< some kilobytes of stack
  std::string xml_, data_;
};

}  // namespace

std::vector<FrameParticle> frame_particles(const meltsim::ParticleFrame& frame) {
  std::vector<FrameParticle> list;
  list.reserve(std::max<std::size_t>(1, frame.id.size()));
  const ParticleColumns columns(frame);
  for (std::size_t i = 0; i < frame.id.size(); ++i) list.push_back(columns.particle(i));
  if (list.empty()) {
    list.push_back({{0, 0, 0}, {0, 0, 0}, 0, 255, -1, std::numeric_limits<std::uint32_t>::max(), 0, 0});
  }
  return list;
}

std::vector<std::string> content_columns(const meltsim::ParticleFrame& frame,
                                         const std::vector<std::string>& names) {
  std::vector<std::string> columns;
  for (const meltsim::MaterialId species : frame.species) {
    std::string column =
        "w_" + (species.index < names.size() ? names[species.index] : std::string("species"));
    for (char& c : column)
      if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
    while (std::find(columns.begin(), columns.end(), column) != columns.end()) column += "_";
    columns.push_back(column);
  }
  return columns;
}

namespace {

/// THE columns of frames: visit(member, name in VTP, names in PLY), in the order of PLY. `Points` are no column of VTP.
template <class Visit>
void each_column(const Visit& visit) {
  visit(&FrameParticle::position, "Points", {"x", "y", "z"});
  visit(&FrameParticle::velocity, "velocity", {"vx", "vy", "vz"});
  visit(&FrameParticle::temperature, "temperature", {"temperature"});
  visit(&FrameParticle::phase, "phase", {"phase"});
  visit(&FrameParticle::body, "body", {"body"});
  visit(&FrameParticle::id, "id", {"id"});
  visit(&FrameParticle::material, "material", {"material"});
  visit(&FrameParticle::liquid_fraction, "liquid_fraction", {"liquid_fraction"});
}
using Names = std::initializer_list<const char*>;

/// How both kinds of file name a type.
struct TypeNames {
  const char *ply, *vtp;
};
constexpr TypeNames names_of(float) { return {"float", "Float32"}; }
constexpr TypeNames names_of(std::uint8_t) { return {"uchar", "UInt8"}; }
constexpr TypeNames names_of(std::int32_t) { return {"int", "Int32"}; }
constexpr TypeNames names_of(std::uint32_t) { return {"uint", "UInt32"}; }

/// The item of a member and how many there are.
template <class M>
struct Items {
  using Item = M;
  static constexpr int count = 1;
  static const M& at(const M& value, int) { return value; }
};
template <class M, std::size_t N>
struct Items<M[N]> {
  using Item = M;
  static constexpr int count = static_cast<int>(N);
  static const M& at(const M (&value)[N], int k) { return value[k]; }
};

std::string ply_header(std::size_t particles, double time, const std::vector<std::string>& contents) {
  std::string text = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment meltsim particles\ncomment time_s {:.9g}\n"
      "comment units m, m/s, degrees Celsius; phase 0 liquid, 1 solid\nelement vertex {}\n",
      time, particles);
  each_column([&text](auto member, const char*, Names names) {
    using Item =
        typename Items<std::remove_reference_t<decltype(std::declval<FrameParticle&>().*member)>>::Item;
    for (const char* name : names) text += fmt::format("property {} {}\n", names_of(Item{}).ply, name);
  });
  for (const std::string& name : contents) text += fmt::format("property float {}\n", name);
  return text + "end_header\n";
}

/// Bytes of a row of PLY, without contents.
std::size_t ply_row() {
  std::size_t bytes = 0;
  each_column(
      [&bytes](auto member, const char*, Names) { bytes += sizeof(std::declval<FrameParticle&>().*member); });
  return bytes;
}

/// Appends `count` rows; get(i) is the i-th particle.
template <class Get>
void append_ply_rows(std::string& text, std::size_t count, std::size_t species, const Get& get) {
  const std::size_t begin = text.size();
  text.resize(begin + count * (ply_row() + species * sizeof(float)));
  char* to = text.data() + begin;
  const auto put = [&to](const auto& value) {
    std::memcpy(to, &value, sizeof(value));
    to += sizeof(value);
  };
  for (std::size_t i = 0; i < count; ++i) {
    const FrameParticle p = get(i);
    each_column([&](auto member, const char*, Names) { put(p.*member); });
    for (std::size_t k = 0; k < species; ++k) put(p.contents[k]);
  }
}

}  // namespace

std::string ply_text(const std::vector<FrameParticle>& particles, double time,
                     const std::vector<std::string>& contents) {
  std::string text = ply_header(particles.size(), time, contents);
  append_ply_rows(text, particles.size(), contents.size(),
                  [&particles](std::size_t i) { return particles[i]; });
  return text;
}

void write_ply(const std::string& path, const meltsim::ParticleFrame& frame, double time,
               const std::vector<std::string>& contents) {
  const std::size_t n = frame.id.size();
  if (n == 0) return write_file(path, ply_text(frame_particles(frame), time, contents));
  const ParticleColumns columns(frame);
  constexpr std::size_t part = 8192;  // rows; they stay in the processor's cache until they are written
  std::size_t done = 0;
  bool begun = false;
  write_file(path, [&](std::string& text) {
    if (!std::exchange(begun, true)) text = ply_header(n, time, contents);
    const std::size_t rows = std::min(part, n - done);
    append_ply_rows(text, rows, contents.size(),
                    [&columns, done](std::size_t i) { return columns.particle(done + i); });
    done += rows;
  });
}

namespace {

/// What lies around the arrays of a VTP file, and the arrays.
struct VtpParts {
  std::string head, data, tail;
};

/// at(i) is the i-th particle.
template <class At>
VtpParts vtp_parts(std::size_t n, double time, const std::vector<std::string>& contents, const At& at) {
  constexpr std::size_t headings = 1024;  // lengths of arrays, generously
  const std::size_t row = ply_row() + 2 * sizeof(std::int64_t) + contents.size() * sizeof(float);
  VtpArrays arrays(row * n + headings);
  const auto add = [&](auto member, const char* name) {
    using Column = Items<std::remove_reference_t<decltype(std::declval<FrameParticle&>().*member)>>;
    using Item = typename Column::Item;
    arrays.add<Item>(names_of(Item{}).vtp, name, Column::count, n,
                     [&at, member](std::size_t i, int c) { return Column::at(at(i).*member, c); });
  };
  const std::string place = "Points";
  each_column([&](auto member, const char* name, Names) {
    if (name != place) add(member, name);
  });
  for (std::size_t k = 0; k < contents.size(); ++k)
    arrays.add<float>("Float32", contents[k].c_str(), 1, n,
                      [&](std::size_t i, int) { return at(i).contents[k]; });
  const std::string point_data = arrays.take_xml();
  add(&FrameParticle::position, place.c_str());
  const std::string points = arrays.take_xml();
  arrays.add<std::int64_t>("Int64", "connectivity", 1, n,
                           [](std::size_t i, int) { return static_cast<std::int64_t>(i); });
  arrays.add<std::int64_t>("Int64", "offsets", 1, n,
                           [](std::size_t i, int) { return static_cast<std::int64_t>(i + 1); });
  const std::string vertices = arrays.take_xml();
  std::string head = fmt::format(
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
      "  <PolyData>\n    <FieldData>\n"
      "      <DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" "
      "format=\"ascii\">{:.9g}</DataArray>\n"
      "    </FieldData>\n"
      "    <Piece NumberOfPoints=\"{}\" NumberOfVerts=\"{}\" NumberOfLines=\"0\" NumberOfStrips=\"0\" "
      "NumberOfPolys=\"0\">\n"
      "      <PointData Vectors=\"velocity\" Scalars=\"temperature\">\n{}      </PointData>\n"
      "      <Points>\n{}      </Points>\n      <Verts>\n{}      </Verts>\n"
      "    </Piece>\n  </PolyData>\n  <AppendedData encoding=\"raw\">\n_",
      time, n, n, point_data, points, vertices);
  return {std::move(head), arrays.take_data(), "\n  </AppendedData>\n</VTKFile>\n"};
}

}  // namespace

std::string vtp_text(const std::vector<FrameParticle>& particles, double time,
                     const std::vector<std::string>& contents) {
  const VtpParts parts =
      vtp_parts(particles.size(), time, contents, [&particles](std::size_t i) { return particles[i]; });
  return parts.head + parts.data + parts.tail;
}

void write_vtp(const std::string& path, const meltsim::ParticleFrame& frame, double time,
               const std::vector<std::string>& contents) {
  const std::size_t n = frame.id.size();
  if (n == 0) return write_file(path, vtp_text(frame_particles(frame), time, contents));
  const ParticleColumns columns(frame);
  VtpParts parts = vtp_parts(n, time, contents, [&columns](std::size_t i) { return columns.particle(i); });
  std::string* const in_order[] = {&parts.head, &parts.data, &parts.tail};
  std::size_t written = 0;
  write_file(path, [&](std::string& text) {
    if (written < std::size(in_order)) text = std::move(*in_order[written++]);
  });
}

std::string pvd_text(const std::vector<std::pair<double, std::string>>& frames) {
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
      "  <Collection>\n";
  for (const auto& [time, file] : frames) {
    text += fmt::format("    <DataSet timestep=\"{:.9g}\" part=\"0\" file=\"{}\"/>\n", time, file);
  }
  return text + "  </Collection>\n</VTKFile>\n";
}

}  // namespace runner
