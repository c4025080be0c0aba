// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "shape/mesh_formats.hpp"
#include "shape_support.hpp"

namespace shape_tests {
namespace {

using meltsim::ErrorCode;
using meltsim::read_mesh;
using meltsim::Result;

// A tetrahedron is the smallest closed mesh: 4 vertices, 4 triangles, volume 1/6.
const float corners[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
const std::uint32_t faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};

class MeshFile : public testing::Test {
 protected:
  void SetUp() override {
    // Cases run in parallel processes: each has a directory of its own.
    directory_ = std::filesystem::temp_directory_path() / ("meltsim_mesh_io_" + std::to_string(::getpid()));
    std::filesystem::create_directory(directory_);
  }
  void TearDown() override { std::filesystem::remove_all(directory_); }

  std::string path(const std::string& name) const { return (directory_ / name).string(); }

  // The name says nothing about the format: it has to be recognised by its content.
  Result<TriangleMesh> read(const std::string& content) const {
    std::ofstream(path("file.dat"), std::ios::binary) << content;
    return read_mesh(path("file.dat"));
  }

  void expect_tetrahedron(const std::string& content) const {
    const Result<TriangleMesh> m = read(content);
    ASSERT_TRUE(m) << m.error().message;
    ASSERT_EQ(m->vertices.size(), 4u);
    ASSERT_EQ(m->indices.size(), 12u);
    for (int f = 0; f < 4; ++f)
      for (int k = 0; k < 3; ++k) {
        const Vec3d v = m->vertices[m->indices[static_cast<std::size_t>(3 * f + k)]];
        const float* c = corners[faces[f][k]];
        EXPECT_TRUE(v.x == static_cast<double>(c[0]) && v.y == static_cast<double>(c[1]) &&
                    v.z == static_cast<double>(c[2]))
            << "face " << f << " corner " << k;
      }
  }

  /// The message has to name the file, the place, and what was wrong.
  void expect_error(const std::string& content, const std::string& place, const std::string& what) const {
    const Result<TriangleMesh> m = read(content);
    ASSERT_FALSE(m) << "accepted; expected: " << what;
    EXPECT_EQ(m.error().code, ErrorCode::invalid_argument);
    for (const std::string& part : {std::string("file.dat"), place, what})
      EXPECT_NE(m.error().message.find(part), std::string::npos) << m.error().message << "\nlacks: " << part;
  }

  std::filesystem::path directory_;
};

template <class T>
std::string bytes_of(T value, bool big_endian = false) {
  std::string s(sizeof value, '\0');
  std::memcpy(s.data(), &value, sizeof value);
  const std::uint16_t one = 1;
  unsigned char low = 0;
  std::memcpy(&low, &one, 1);
  return big_endian == (low == 1) ? std::string(s.rbegin(), s.rend()) : s;
}

std::string binary_stl(const std::string& header = {}) {
  std::string s = header + std::string(80 - header.size(), '\0') + bytes_of(std::uint32_t{4});
  for (const auto& f : faces) {
    for (int i = 0; i < 3; ++i) s += bytes_of(0.0f);
    for (const std::uint32_t v : f)
      for (const float c : corners[v]) s += bytes_of(c);
    s += std::string(2, '\0');
  }
  return s;
}

std::string text_stl() {
  std::string s = "solid tetrahedron\n";
  for (const auto& f : faces) {
    s += "  facet normal nan nan nan\n    outer loop\n";
    for (const std::uint32_t v : f)
      s += "      vertex " + std::to_string(corners[v][0]) + " " + std::to_string(corners[v][1]) + " " +
           std::to_string(corners[v][2]) + "\n";
    s += "    endloop\n  endfacet\n";
  }
  return s + "endsolid tetrahedron\n";
}

const char* const obj =
    "# tetrahedron\nmtllib x.mtl\no t\nv 0 0 0\nv +1.0 0 0 1.0\nv 0 1e0 0 0.5 0.5 0.5\nvn 0 0 1\nvt 0 0\n"
    "v 0 0 1\ns off\nf 1 3 2\nf 1/1 2/1 4/1\nf 1//1 4//1 -2//1 # half of it backwards\nf 2/1/1 3/1/1 4/1/1\n";

std::string ply_header(const std::string& format, const std::string& extra = {}) {
  return "ply\nformat " + format + " 1.0\ncomment of someone\nelement vertex 4\nproperty uchar red\n" +
         "property float x\nproperty float y\nproperty double z\n" + extra +
         "element face 4\nproperty list uchar int vertex_indices\nproperty short group\nend_header\n";
}

std::string text_ply() {
  std::string s = ply_header("ascii", "element edge 2\nproperty list uint8 uint16 ends\n");
  for (const auto& c : corners)
    s += "255 " + std::to_string(c[0]) + " " + std::to_string(c[1]) + " " + std::to_string(c[2]) + "\n";
  s += "2 0 1\n\n0\n";
  for (const auto& f : faces)
    s += "3 " + std::to_string(f[0]) + " " + std::to_string(f[1]) + " " + std::to_string(f[2]) + " -7\n";
  return s;
}

std::string binary_ply(bool big) {
  std::string s = ply_header(big ? "binary_big_endian" : "binary_little_endian",
                             "element edge 2\nproperty list uint8 uint16 ends\n");
  for (const auto& c : corners)
    s += "\xff" + bytes_of(c[0], big) + bytes_of(c[1], big) + bytes_of(static_cast<double>(c[2]), big);
  s += "\x02" + bytes_of(std::uint16_t{0}, big) + bytes_of(std::uint16_t{1}, big) + std::string(1, '\0');
  for (const auto& f : faces) {
    s += "\x03";
    for (const std::uint32_t v : f) s += bytes_of(static_cast<std::int32_t>(v), big);
    s += bytes_of(std::int16_t{-7}, big);
  }
  return s;
}

std::string with_windows_lines(const std::string& s) {
  std::string out;
  for (const char c : s) out += c == '\n' ? std::string("\r\n") : std::string(1, c);
  return out;
}

std::string replaced(std::string s, const std::string& what, const std::string& by) {
  const std::size_t at = s.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return at == std::string::npos ? s : s.replace(at, what.size(), by);
}

/// A tetrahedron as glTF, its vertices twice as large and 1 to the right by its node's transform.
std::string gltf() {
  std::string data;
  for (const auto& c : corners)
    for (const float x : c) data += bytes_of(x);
  for (const auto& f : faces)
    for (const std::uint32_t v : f) data += bytes_of(static_cast<std::uint16_t>(v));
  const char* const digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string base64;
  for (std::size_t k = 0; k < data.size(); k += 3) {  // 72 bytes: no padding
    const auto byte = [&](std::size_t n) {
      return static_cast<unsigned>(static_cast<unsigned char>(data[k + n]));
    };
    const unsigned word = byte(0) << 16 | byte(1) << 8 | byte(2);
    for (int shift = 18; shift >= 0; shift -= 6) base64 += digits[(word >> shift) & 63u];
  }
  return R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
    "nodes": [{"mesh": 0, "scale": [2, 2, 2], "translation": [1, 0, 0]}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0],
      "max": [1, 1, 1]}, {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}],
    "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}],
    "buffers": [{"byteLength": 72, "uri": "data:application/octet-stream;base64,)" +
         base64 + R"("}]})";
}

// What begins as a binary glTF is none of the binary STL that it would be read as. Cut off: no reader takes it.
TEST_F(MeshFile, ABinaryGltfIsNoStl) {
  std::ofstream(path("t.glb"), std::ios::binary) << std::string("glTF\2\0\0\0", 8) + std::string(200, '\0');
  const Result<TriangleMesh> m = read_mesh(path("t.glb"));
  ASSERT_FALSE(m);
  EXPECT_NE(m.error().message.find("the file is a binary glTF; convert the mesh to OBJ, STL or PLY ("),
            std::string::npos)
      << m.error().message;
}

// Of what is packed or known by its first bytes the message says what it is; cut off, no reader takes it.
TEST_F(MeshFile, PackedFilesAndFbxAreNamed) {
  const std::string rest(200, '\0');
  const std::pair<std::string, std::string> files[] = {
      {"\x1f\x8b\x08" + rest, "the file is compressed with gzip; unpack it (gunzip)"},
      {"PK\3\4" + rest, "the file is a ZIP archive; unpack it"},
      {"Kaydara FBX Binary  " + rest, "the file is FBX; convert the mesh to OBJ, STL or PLY ("},
      {"; FBX 7.3.0 project file\n", "the file is FBX; convert the mesh to OBJ, STL or PLY ("}};
  for (const auto& [bytes, said] : files) {
    std::ofstream(path("t.obj"), std::ios::binary) << bytes;
    const Result<TriangleMesh> m = read_mesh(path("t.obj"));
    ASSERT_FALSE(m) << said;
    EXPECT_NE(m.error().message.find(said), std::string::npos) << m.error().message;
  }
}

TEST_F(MeshFile, StripsOfTrianglesAreRefusedByName) {
  std::ofstream(path("t.ply"))
      << "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
         "property float z\nelement tristrips 1\nproperty list int int vertex_indices\n"
         "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  const Result<TriangleMesh> m = read_mesh(path("t.ply"));
  ASSERT_FALSE(m);
  EXPECT_NE(m.error().message.find("('tristrips'), which are not read; export triangles"), std::string::npos)
      << m.error().message;
}

TEST_F(MeshFile, OtherFormatsGoThroughAssimp) {
  std::ofstream(path("t.gltf")) << gltf();
  const Result<TriangleMesh> m = read_mesh(path("t.gltf"));
  if (!m && m.error().message.find("MELTSIM_ASSIMP") != std::string::npos)
    GTEST_SKIP() << "built without assimp";
  ASSERT_TRUE(m) << m.error().message;
  ASSERT_EQ(m->vertices.size(), 4u);
  ASSERT_EQ(m->indices.size(), 12u);
  double volume = 0;
  for (std::size_t f = 0; f < 12; f += 3)
    volume += meltsim::dot(m->vertices[m->indices[f]],
                           meltsim::cross(m->vertices[m->indices[f + 1]], m->vertices[m->indices[f + 2]])) /
              6;
  EXPECT_NEAR(volume, 8.0 / 6, 1e-6);  // outward, and eight times as large
  double least = 10;
  for (const Vec3d& v : m->vertices) least = std::min(least, v.x);
  EXPECT_EQ(least, 1.0);
}

// Broken, and of a format whose name assimp knows.
TEST_F(MeshFile, WhatAssimpCannotReadIsAnErrorWithItsReason) {
  std::ofstream(path("t.gltf")) << gltf().substr(0, 200);
  const Result<TriangleMesh> m = read_mesh(path("t.gltf"));
  ASSERT_FALSE(m);
  EXPECT_EQ(m.error().code, ErrorCode::invalid_argument);
  EXPECT_NE(m.error().message.find("t.gltf"), std::string::npos) << m.error().message;
  EXPECT_NE(m.error().message.find("convert the mesh"), std::string::npos) << m.error().message;
}

TEST_F(MeshFile, ReadsObj) {
  expect_tetrahedron(obj);
  expect_tetrahedron(with_windows_lines(obj));
  expect_tetrahedron(replaced(obj, "f 1 3 2\n", "f 1 \\\n3\\\r\n 2\n"));
}

TEST_F(MeshFile, ReadsTextStl) {
  expect_tetrahedron(text_stl());
  expect_tetrahedron(with_windows_lines(text_stl()));
  expect_tetrahedron(replaced(replaced(text_stl(), "solid", "\n SOLID"), "vertex", "VERTEX"));
  // The two zeros are the same corner.
  expect_tetrahedron(replaced(text_stl(), "vertex 0.000000", "vertex -0.000000"));
}

TEST_F(MeshFile, ReadsBinaryStl) {
  expect_tetrahedron(binary_stl());
  expect_tetrahedron(binary_stl("solid as many exporters write"));
}

TEST_F(MeshFile, ReadsPly) {
  expect_tetrahedron(text_ply());
  expect_tetrahedron(with_windows_lines(text_ply()));
  expect_tetrahedron(binary_ply(false));
  expect_tetrahedron(binary_ply(true));
  expect_tetrahedron(replaced(text_ply(), "vertex_indices", "vertex_index"));
}

TEST_F(MeshFile, SplitsPolygonsIntoFans) {
  const Result<TriangleMesh> m = read("v 0 0 0\nv 1 0 0\nv 2 1 0\nv 1 2 0\nv 0 2 0\nf 1 2 3 4 5\n");
  ASSERT_TRUE(m) << m.error().message;
  EXPECT_EQ(m->indices, (std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3, 0, 3, 4}));
}

TEST_F(MeshFile, FacesMayPrecedeVertices) { EXPECT_TRUE(read("f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n")); }

TEST_F(MeshFile, MissingEmptyAndSpecialFiles) {
  const auto missing = read_mesh(path("nothing.obj"));
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().message.find("nothing.obj': there is no such file"), std::string::npos);
  const auto folder = read_mesh(directory_.string());
  ASSERT_FALSE(folder);
  EXPECT_NE(folder.error().message.find("regular file"), std::string::npos) << folder.error().message;
  EXPECT_FALSE(read_mesh("/dev/zero")) << "would never end";
  EXPECT_FALSE(read_mesh(""));
  EXPECT_FALSE(read_mesh(std::string("a\0b", 3)));
  const auto empty = read("");
  ASSERT_FALSE(empty);
  EXPECT_NE(empty.error().message.find("empty"), std::string::npos);
}

TEST_F(MeshFile, UnknownFormats) {
  expect_error("hello\nworld\n", "line 1", "the file is none of OBJ, STL and PLY");
  expect_error("\n\n", "line 1", "the file is none of OBJ, STL and PLY");
  expect_error(std::string("\x89PNG\r\n\0\0", 8), "byte 8", "binary STL");
  expect_error(std::string(1000, '\0'), "byte 1000", "none of OBJ, STL and PLY");
}

TEST_F(MeshFile, ObjErrors) {
  expect_error("v 0 0\n", "line 1", "expected three coordinates, found the end of the line");
  expect_error("v 0 0 zero\n", "line 1", "found 'zero'");
  expect_error("v 0 0 0x10\n", "line 1", "found '0x10'");
  expect_error("v 0 0 nan\n", "line 1", "finite");
  expect_error("v 0 0 0\nv 1e999 0 0\n", "line 2", "finite");
  expect_error("v 0 0 0\nv 1 0 0\nv 0 1 0\n\nf 1 2\n", "line 5", "at least 3 corners, found 2");
  expect_error("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\nf 1 2 3\n", "line 4", "vertex 4 but the file has 3");
  expect_error("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 -4\n", "line 4", "vertex -4");
  expect_error("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 0\n", "line 4", "vertex 0");
  expect_error("v 0 0 0\nf 1 2 99999999999\n", "line 2", "vertex 99999999999");
  expect_error("v 0 0 0\nf 1 2 99999999999999999999\n", "line 2", "found '99999999999999999999'");
  expect_error("v 0 0 0\nf 1 2 x\n", "line 2", "found 'x'");
  expect_error("v 0 0 0\nf 1/a 2 3\n", "line 2", "found '1/a'");
  expect_error("v 0 0 0\nf /1 /2 /3\n", "line 2", "found '/1'");
  expect_error("v 0 0 0\nv 1 0 0\nv 0 1 0\n", "line 3", "at least one face");
  expect_error("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 \\\n 2 \\\n 3\nf 1 2 7\n", "line 7", "vertex 7");
}

TEST_F(MeshFile, TextStlErrors) {
  expect_error("solid\nendsolid\n", "line 2", "at least one face");
  expect_error("solid\nfacte normal 0 0 1\n", "line 2", "expected 'facet' or 'endsolid', found 'facte'");
  expect_error("solid\nfacet normal 0 0 1\nvertex 0 0 0\n", "line 3", "expected 'outer'");
  expect_error(replaced(text_stl(), "vertex 0.000000", "vertex nan"), "line 4", "finite");
  expect_error(replaced(text_stl(), "vertex 0.000000", "vertex ?"), "line 4", "three coordinates");
  expect_error(replaced(text_stl(), "      vertex 0.000000 0.000000 0.000000\n", ""), "line 2",
               "at least 3 corners");
  // Cut between any two lines the file must not pass for a smaller mesh.
  const std::string whole = text_stl();
  for (std::size_t cut = whole.find('\n') + 1; cut < whole.size(); cut = whole.find('\n', cut) + 1)
    expect_error(whole.substr(0, cut), "line ", "cut off");
}

TEST_F(MeshFile, BinaryStlErrors) {
  const std::string whole = binary_stl();
  for (const std::size_t size : {std::size_t{83}, std::size_t{84}, std::size_t{100}, whole.size() - 1})
    expect_error(whole.substr(0, size), "byte " + std::to_string(size), "cut off");
  expect_error(whole + "x", "byte 285", "has 284 bytes but the file has 285");
  std::string bad = whole;
  // Second corner of the second triangle: 84 + 50 + 12 (normal) + 12.
  bad.replace(158, 4, bytes_of(std::nanf("")));
  expect_error(bad, "byte 158", "finite");
  expect_error(std::string(84, '\0'), "byte 84", "at least one face");
}

TEST_F(MeshFile, PlyHeaderErrors) {
  expect_error("ply\nformat ascii 1.0\nelement vertex 3\n", "line 3", "cut off");
  expect_error("ply\nformat middle_endian 1.0\n", "line 2", "found 'middle_endian'");
  expect_error("ply\nelement vertex 1\nproperty float x\nend_header\n", "line 4", "'format' before");
  expect_error("ply\nformat ascii 1.0\nelement vertex many\n", "line 3", "found 'many'");
  expect_error("ply\nformat ascii 1.0\nelement vertex -3\n", "line 3", "found '-3'");
  expect_error("ply\nformat ascii 1.0\nproperty float x\n", "line 3", "'element' before 'property'");
  expect_error("ply\nformat ascii 1.0\nelement vertex 1\nproperty half x\n", "line 4", "found 'half'");
  expect_error("ply\nformat ascii 1.0\nelement vertex 1\nproperty list float int x\n", "line 4",
               "integer type");
  expect_error("ply\nformat ascii 1.0\nelement vertex 1\nproperty float\n", "line 4", "name of the property");
  expect_error("ply\nformat ascii 1.0\nelephant\n", "line 3", "found 'elephant'");
  expect_error("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n", "line 3",
               "property 'y'");
  expect_error("ply\nformat ascii 1.0\nelement face 1\nproperty int x\nend_header\n0\n", "line 3",
               "vertex_indices");
  expect_error("ply\nformat ascii 1.0\nelement face 50000001\n", "line 3", "50 million");
  // Elements without properties take no room: the count alone must not keep the reader busy.
  expect_error("ply\nformat ascii 1.0\nelement x 9000000000000000000\nend_header\n", "line ",
               "at least one face");
}

TEST_F(MeshFile, PlyBodyErrors) {
  expect_error(replaced(text_ply(), "255 0.0", "255 nan 0.0"), "line 15", "end of the line");
  expect_error(replaced(text_ply(), "255 0.000000", "255 inf"), "line 15", "finite");
  expect_error(replaced(text_ply(), "255 0.000000 0.000000 0.000000", "255 0"), "line 15",
               "a number for 'y'");
  expect_error(replaced(text_ply(), "255", "2.5"), "line 15", "an integer for 'red'");
  expect_error(replaced(text_ply(), "3 0 2 1", "3 0 2 4"), "line 22", "vertex 4 but the file has 4");
  expect_error(replaced(text_ply(), "3 0 2 1", "3 0 2 -1"), "line 22", "vertex -1");
  expect_error(replaced(text_ply(), "3 0 2 1", "2 0 2"), "line 22", "at least 3 corners");
  expect_error(replaced(text_ply(), "3 0 2 1", "-3 0 2 1"), "line 22", "length of the list");
  expect_error(replaced(text_ply(), "3 0 2 1", "4000000000 0 2 1"), "line 22",
               "an integer for 'vertex_indices'");
  expect_error(replaced(text_ply(), "3 0 2 1", "3 0 2 9223372036854775807"), "line 22",
               "an integer for 'vertex_indices'");
  const std::string text = text_ply();
  expect_error(text.substr(0, text.size() - 12), "line ", "cut off");
  for (const bool big : {false, true}) {
    const std::string whole = binary_ply(big);
    const std::size_t body = whole.find("end_header\n") + 11;
    // Nothing behind the header is padding: without its last byte no part of the file is complete.
    for (std::size_t size = body; size < whole.size(); size += 7)
      expect_error(whole.substr(0, size), "byte ", "cut off");
    std::string bad = whole;
    bad.replace(body + 1, 4, bytes_of(std::nanf(""), big));
    expect_error(bad, "byte " + std::to_string(body), "finite");
    bad = whole;
    bad.replace(whole.size() - 2 - 4, 4, bytes_of(std::int32_t{4}, big));
    expect_error(bad, "byte ", "vertex 4 but the file has 4");
    bad.replace(whole.size() - 2 - 4, 4, bytes_of(std::int32_t{-1}, big));
    expect_error(bad, "byte ", "vertex -1");
  }
}

TEST(MeshContent, DamageNeverCrashes) {
  // Every byte of small files set to a few telling values, and every length: whatever comes of it, it is a
  // mesh or an error. Without files on a disk this takes milliseconds.
  const auto survives = [](const std::string& bytes) {
    const Result<TriangleMesh> m = meltsim::read_any_mesh({bytes, "damaged"});
    if (!m) return !m.error().message.empty();
    for (const std::uint32_t v : m->indices)
      if (v >= m->vertices.size()) return false;
    return Shape::mesh(*m).validate().ok();
  };
  for (const std::string& good : {std::string(obj), text_stl(), binary_stl(), text_ply(), binary_ply(true)})
    for (std::size_t i = 0; i < good.size(); ++i) {
      ASSERT_TRUE(survives(good.substr(0, i))) << "cut at " << i;
      for (const char c : {'\0', '\xff', '9', '-', ' ', '\n'}) {
        std::string bad = good;
        bad[i] = c;
        ASSERT_TRUE(survives(bad)) << "byte " << i << " = " << static_cast<int>(c) << " in "
                                   << good.substr(0, 5);
      }
    }
}

TEST_F(MeshFile, ReadMeshIsSampledAsASolid) {
  const Result<TriangleMesh> m = read(binary_stl());
  ASSERT_TRUE(m) << m.error().message;
  // Faces of the unit tetrahedron: three of 1/2 and one of sqrt(3)/2. Three of them lie along the lattice,
  // where whole layers of h^3 / 2 h^2 sites are misjudged together: half a layer each on top.
  const double h = 0.02, area = 1.5 + std::sqrt(3.0) / 2;
  EXPECT_NEAR(sampled_volume(Shape::mesh(*m), h), 1.0 / 6, volume_tolerance(area, h) + 1.5 * h / 2);
}

}  // namespace
}  // namespace shape_tests
