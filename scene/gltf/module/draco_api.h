// The interface of crowdbench_draco.so, which brings Draco: plain functions and structs. scene/gltf/gltf_draco.h is
// what to use.
#pragma once
#include <cstddef>
#include <cstdint>

namespace crowdbench::scene::draco_module {

inline constexpr uint32_t kApiVersion = 1;
inline constexpr int kMessageBytes = 256;

// What a mesh may claim; more is refused before memory is spent on it.
struct Limits {
  uint32_t points;
  uint32_t faces;
  uint64_t bytes;  // of all attributes
};

struct Mesh;

struct Api {
  uint32_t version;
  // Null on failure, with a one-line reason in `message` (kMessageBytes long). Never throws.
  Mesh* (*decode)(const uint8_t* bytes, size_t size, const Limits* limits, char* message);
  uint32_t (*points)(const Mesh* mesh);
  uint32_t (*faces)(const Mesh* mesh);
  // Writes points * components values, tightly packed. gltf_type: glTF's number of a component type. False: there is no
  // such attribute, or not of so many components.
  bool (*attribute)(const Mesh* mesh, uint32_t unique_id, int32_t gltf_type, int32_t components, void* out);
  void (*indices)(const Mesh* mesh, uint32_t* out);  // 3 * faces, each below points
  void (*free)(Mesh* mesh);
};

inline constexpr char kApiSymbol[] = "crowdbench_draco_api";
using ApiFunction = const Api* (*)();

}  // namespace crowdbench::scene::draco_module
