// SPDX-License-Identifier: Apache-2.0
// Every other mesh format, through assimp. Built where MELTSIM_ASSIMP is on; else mesh_no_assimp.cpp.
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>

#include "shape/mesh_formats.hpp"

namespace meltsim {
inline namespace v0 {
namespace {

/// Transforms of nodes are applied to the vertices; only positions of vertices are kept, so that
/// vertices at the same position become one; points and lines are left out.
constexpr unsigned steps = aiProcess_Triangulate | aiProcess_PreTransformVertices |
                           aiProcess_RemoveComponent | aiProcess_JoinIdenticalVertices |
                           aiProcess_SortByPType;

}  // namespace

std::optional<Result<TriangleMesh>> read_other(const MeshSource& source, std::string& why_not) {
  const FilePlace start{FilePlace::byte, 0};
  Assimp::Importer importer;
  importer.SetPropertyInteger(AI_CONFIG_PP_RVC_FLAGS,
                              aiComponent_NORMALS | aiComponent_TANGENTS_AND_BITANGENTS | aiComponent_COLORS |
                                  aiComponent_TEXCOORDS | aiComponent_BONEWEIGHTS | aiComponent_ANIMATIONS |
                                  aiComponent_TEXTURES | aiComponent_LIGHTS | aiComponent_CAMERAS);
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  // By name, not from the bytes: some formats keep their vertices in a file beside it.
  const aiScene* const scene = importer.ReadFile(source.name, steps);
  if (scene == nullptr || (scene->mFlags & AI_SCENE_FLAGS_INCOMPLETE) != 0u) {
    why_not = std::string("assimp: ") + (scene == nullptr ? importer.GetErrorString() : "incomplete");
    return std::nullopt;
  }
  MeshBuilder builder(source);
  std::uint64_t triangles = 0;
  for (unsigned k = 0; k < scene->mNumMeshes; ++k) triangles += scene->mMeshes[k]->mNumFaces;
  if (const Status fits = check_triangle_count(source, triangles, start); !fits)
    return Result<TriangleMesh>(fits.error());
  for (unsigned k = 0; k < scene->mNumMeshes; ++k) {
    const aiMesh& mesh = *scene->mMeshes[k];
    const auto first = static_cast<std::int64_t>(builder.vertices());
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
      const aiVector3D& p = mesh.mVertices[v];
      const Status taken = builder.vertex({double(p.x), double(p.y), double(p.z)}, start);
      if (!taken) return Result<TriangleMesh>(taken.error());
    }
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      std::vector<std::int64_t> corners(face.mIndices, face.mIndices + face.mNumIndices);
      for (std::int64_t& c : corners) c += first;
      const Status taken = builder.face(corners, start, 0);
      if (!taken) return Result<TriangleMesh>(taken.error());
    }
  }
  return builder.finish(start);
}

}  // namespace v0
}  // namespace meltsim
