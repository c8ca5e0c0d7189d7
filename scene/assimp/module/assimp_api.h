// The interface of crowdbench_assimp.so, which brings Assimp: plain functions and structs. scene/assimp/assimp.h is
// what to use.
#pragma once
#include <cstddef>
#include <cstdint>

namespace crowdbench::scene::assimp_module {

inline constexpr uint32_t kApiVersion = 1;
inline constexpr size_t kUriBytes = 1024;

enum class Format : uint32_t { fbx, collada };

// What a scene may hold; more is refused before it is converted. GltfLimits says what each is.
struct Limits {
  uint64_t nodes;
  uint64_t triangles;
  uint64_t keys;
  uint64_t clips;
  uint64_t clip_nodes;
};

enum class Picture : uint32_t {
  readable,
  missing,
  unreadable  // of a kind that is not read
};

// What is passed to `write`.
enum class Item : uint32_t {
  refusal,  // one line; the last that is written
  warning,  // one line
  label,    // "/nodes/3<TAB>node Hips": what the document's element is to the user
  glb       // the document; the last that is written
};

struct Request {
  const uint8_t* bytes;  // the file
  size_t size;
  Format format;
  Limits limits;
  void* context;  // handed to both functions
  // A texture by the path that the file gives. Where it is readable, `uri` (kUriBytes long) becomes the place below the
  // file's folder, as glTF writes it.
  Picture (*find_picture)(void* context, const char* path, char* uri);
  // Whether bytes that the file holds are a picture that is read.
  Picture (*judge_picture)(void* context, const uint8_t* bytes, size_t size);
  void (*write)(void* context, Item item, const char* data, size_t size);
};

struct Api {
  uint32_t version;
  // Throws nothing but std::bad_alloc.
  void (*convert)(const Request* request);
};

inline constexpr char kApiSymbol[] = "crowdbench_assimp_api";
using ApiFunction = const Api* (*)();

}  // namespace crowdbench::scene::assimp_module
