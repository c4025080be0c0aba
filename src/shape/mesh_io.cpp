// SPDX-License-Identifier: Apache-2.0
// Recognises the format of a mesh file by its content, because names of files may be wrong.
#include <filesystem>
#include <fstream>
#include <new>
#include <stdexcept>

#include "shape/mesh_bytes.hpp"
#include "shape/mesh_formats.hpp"
#include "shape/mesh_text.hpp"

namespace meltsim {
inline namespace v0 {
namespace {

bool binary_stl(std::string_view bytes) {
  return bytes.size() >= 84 && bytes.size() == 84 + 50 * load_bits(bytes.data() + 80, 4, false);
}

/// Text has no zero bytes; binary STL has them in the header or in the first few coordinates.
bool has_zero_byte(std::string_view bytes) {
  return bytes.substr(0, 1024).find('\0') != std::string_view::npos;
}

/// Whether a line anywhere is a vertex or a face as in OBJ: the letter and a number. Exporters put whole pages of comments
/// and unknown keywords in front.
bool looks_like_obj(std::string_view bytes) {
  constexpr std::string_view starts = "0123456789+-./";
  TextLines lines(bytes, true);
  while (lines.next()) {
    const std::string_view word = lines.token();
    if (word != "v" && word != "f") continue;
    const std::string_view number = lines.token();
    if (!number.empty() && starts.find(number[0]) != std::string_view::npos) return true;
  }
  return false;
}

Error file_error(const std::string& path, const std::string& what) {
  return {ErrorCode::invalid_argument, "mesh file '" + path + "': " + what};
}

/// What a file is that begins as none of the formats read here does, and what to do; or nothing.
std::string known_other(std::string_view bytes, const std::string& why_not) {
  const auto begins = [bytes](std::string_view with) { return bytes.substr(0, with.size()) == with; };
  const std::string convert = "; convert the mesh to OBJ, STL or PLY (" + why_not + ")";
  if (begins("glTF")) return "the file is a binary glTF" + convert;
  if (begins("Kaydara FBX Binary") || begins("; FBX")) return "the file is FBX" + convert;
  if (begins("\x1f\x8b")) return "the file is compressed with gzip; unpack it (gunzip)";
  if (begins("PK\3\4")) return "the file is a ZIP archive; unpack it";
  return {};
}

Result<std::string> read_bytes(const std::string& path) {
  std::error_code problem;
  const auto kind = std::filesystem::status(path, problem).type();
  if (kind == std::filesystem::file_type::not_found)
    return file_error(path, "there is no such file; check the path and the working directory");
  // Reading a pipe or a device could block or never end.
  if (kind != std::filesystem::file_type::regular)
    return file_error(path, "expected a regular file; give the path of an OBJ, STL or PLY file");
  const std::uintmax_t size = std::filesystem::file_size(path, problem);
  std::ifstream in(path, std::ios::binary);
  if (problem || !in) return file_error(path, "cannot be opened; check its permissions");
  if (size == 0) return file_error(path, "the file is empty; export the mesh again");
  std::string bytes(size, '\0');
  if (!in.read(bytes.data(), static_cast<std::streamsize>(size)))
    return file_error(path, "only " + std::to_string(in.gcount()) + " of " + std::to_string(size) +
                                " bytes could be read; check the disk");
  return bytes;
}

}  // namespace

Result<TriangleMesh> read_any_mesh(const MeshSource& source) {
  TextLines lines(source.bytes, false);
  std::string_view word;
  while (word.empty() && lines.next()) word = lines.token();
  if (lines.place().number == 1 && word == "ply") return read_ply(source);
  // Binary STL may start with "solid" as well, so its size decides first.
  if (binary_stl(source.bytes)) return read_stl_binary(source);
  const bool text = !has_zero_byte(source.bytes);
  if (text && same_word(word, "solid")) return read_stl_text(source);
  if (text && looks_like_obj(source.bytes)) return read_obj(source);
  std::string why_not;
  if (auto other = read_other(source, why_not)) return *std::move(other);
  if (const std::string known = known_other(source.bytes, why_not); !known.empty())
    return source.error({FilePlace::byte, 0}, known);
  if (!text) return read_stl_binary(source);  // reports what does not fit
  // Quotes nothing: a path given by mistake, or to a service, may name any file.
  return source.error(
      {FilePlace::line, 1},
      "the file is none of OBJ, STL and PLY; convert the mesh to one of these (" + why_not + ")");
}

Result<TriangleMesh> read_mesh(const std::string& path) {
  try {
    const Result<std::string> bytes = read_bytes(path);
    if (!bytes) return bytes.error();
    return read_any_mesh({*bytes, path});
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::out_of_memory, "out of memory"};
  } catch (const std::exception& e) {
    return Error{ErrorCode::internal, e.what()};
  }
}

}  // namespace v0
}  // namespace meltsim
