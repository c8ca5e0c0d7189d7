// Indices and counts of a file as it stands, before Assimp reads it. Internal to the module.
//
// Assimp leaves out a mesh whose indices are wrong without a word that reaches its caller, takes some of them modulo
// something, and ends the process on others. What is looked at here is what a mesh, a skin or a curve says of its own
// lists; what is no FBX or COLLADA at all is left to Assimp, which says so.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace crowdbench::scene::assimp_module {

// Each throws Refusal: one line with the mesh's, bone's or node's name, the list, and the place in it, counted from 0.
// FBX, text or binary, from 6.0 on: vertices, polygons, layers (normals, texture coordinates, colours), clusters, keys,
// and nodes that are their own ancestors.
void check_fbx(std::span<const uint8_t> bytes);
// COLLADA: arrays, accessors, primitives, vertex weights, skin joints.
void check_collada(std::string_view text);

}  // namespace crowdbench::scene::assimp_module
