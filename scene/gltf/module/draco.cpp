// Draco behind the interface of draco_api.h.
//
// The library's own entry points take a file's word for its sizes. So its decoders are derived from here, and stopped
// where the sizes are known and nothing has been allocated for them: before the connectivity, whose counts are peeked
// at, and before the attributes.
#include <draco/compression/config/compression_shared.h>
#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/varint_decoding.h>
#include <draco/mesh/mesh.h>

#include <cstdio>
#include <exception>
#include <memory>
#include <string>

#include "scene/gltf/module/draco_api.h"

namespace crowdbench::scene::draco_module {

struct Mesh {
  draco::Mesh mesh;
};

namespace {

struct Refusal {
  std::string text;
};

void check_counts(uint64_t points, uint64_t faces, const Limits& limits) {
  if (points > limits.points || faces > limits.faces)
    throw Refusal{"claims " + std::to_string(points) + " vertices and " + std::to_string(faces) +
                  " triangles, more than the limits of " + std::to_string(limits.points) + " and " +
                  std::to_string(limits.faces)};
}

template <typename Decoder>
class Bounded : public Decoder {
 public:
  explicit Bounded(const Limits& limits) : limits_(limits) {}

 protected:
  bool DecodeConnectivity() override {
    draco::DecoderBuffer peek = *this->buffer();
    uint32_t first = 0;
    uint32_t second = 0;
    if (!draco::DecodeVarint(&first, &peek) || !draco::DecodeVarint(&second, &peek)) return false;
    constexpr bool sequential = std::is_same_v<Decoder, draco::MeshSequentialDecoder>;
    // Faces and points here, vertices and faces there.
    check_counts(sequential ? second : first, sequential ? first : second, limits_);
    return Decoder::DecodeConnectivity();
  }

  bool DecodeAllAttributes() override {
    const uint64_t points = this->point_cloud()->num_points();
    check_counts(points, 0, limits_);  // a vertex on a seam is several points
    uint64_t bytes = 0;
    for (int32_t a = 0; a < this->point_cloud()->num_attributes(); ++a) {
      const draco::PointAttribute& attribute = *this->point_cloud()->attribute(a);
      bytes += points * static_cast<uint64_t>(attribute.num_components()) *
               static_cast<uint64_t>(draco::DataTypeLength(attribute.data_type()));
    }
    if (bytes > limits_.bytes)
      throw Refusal{"decodes to " + std::to_string(bytes) + " bytes, more than the " + std::to_string(limits_.bytes) +
                    " that are left"};
    return Decoder::DecodeAllAttributes();
  }

 private:
  const Limits& limits_;
};

template <typename Decoder>
draco::Status run(draco::DecoderBuffer& buffer, const Limits& limits, draco::Mesh& mesh) {
  Bounded<Decoder> decoder(limits);
  const draco::DecoderOptions options;
  return decoder.Decode(options, &buffer, &mesh);
}

void decode_into(const uint8_t* bytes, size_t size, const Limits& limits, draco::Mesh& mesh) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes), size);
  draco::DecoderBuffer peek = buffer;
  draco::DracoHeader header;
  if (!draco::PointCloudDecoder::DecodeHeader(&peek, &header).ok()) throw Refusal{"is not Draco data"};
  if (header.encoder_type != draco::TRIANGULAR_MESH) throw Refusal{"is not a mesh"};
  if (header.version_major != 2 || header.version_minor != 2)
    throw Refusal{"is of bitstream " + std::to_string(header.version_major) + "." +
                  std::to_string(header.version_minor) + ", not 2.2"};
  const draco::Status status = header.encoder_method == draco::MESH_EDGEBREAKER_ENCODING
                                   ? run<draco::MeshEdgebreakerDecoder>(buffer, limits, mesh)
                                   : run<draco::MeshSequentialDecoder>(buffer, limits, mesh);
  if (!status.ok()) throw Refusal{"does not decode"};
  for (draco::FaceIndex f(0); f < mesh.num_faces(); ++f)
    for (const draco::PointIndex& corner : mesh.face(f))
      if (corner.value() >= mesh.num_points()) throw Refusal{"has a triangle of vertices that are not there"};
}

Mesh* decode(const uint8_t* bytes, size_t size, const Limits* limits, char* message) {
  std::string why;
  try {
    auto mesh = std::make_unique<Mesh>();
    decode_into(bytes, size, *limits, mesh->mesh);
    return mesh.release();
  } catch (const Refusal& refusal) {
    why = refusal.text;
  } catch (const std::exception&) {
    why = "does not decode";
  }
  std::snprintf(message, kMessageBytes, "%s", why.c_str());
  return nullptr;
}

template <typename T>
bool convert(const draco::Mesh& mesh, const draco::PointAttribute& attribute, int components, void* out) {
  auto* to = static_cast<T*>(out);
  for (draco::PointIndex i(0); i < mesh.num_points(); ++i, to += components) {
    const draco::AttributeValueIndex value = attribute.mapped_index(i);
    if (value.value() >= attribute.size()) return false;
    if (!attribute.ConvertValue<T>(value, static_cast<int8_t>(components), to)) return false;
  }
  return true;
}

bool attribute(const Mesh* mesh, uint32_t unique_id, int32_t gltf_type, int32_t components, void* out) {
  const draco::PointAttribute* found = mesh->mesh.GetAttributeByUniqueId(unique_id);
  if (!found || found->num_components() != components) return false;
  switch (gltf_type) {
    case 5120: return convert<int8_t>(mesh->mesh, *found, components, out);
    case 5121: return convert<uint8_t>(mesh->mesh, *found, components, out);
    case 5122: return convert<int16_t>(mesh->mesh, *found, components, out);
    case 5123: return convert<uint16_t>(mesh->mesh, *found, components, out);
    case 5125: return convert<uint32_t>(mesh->mesh, *found, components, out);
    case 5126: return convert<float>(mesh->mesh, *found, components, out);
    default: return false;
  }
}

void indices(const Mesh* mesh, uint32_t* out) {
  for (draco::FaceIndex f(0); f < mesh->mesh.num_faces(); ++f)
    for (const draco::PointIndex& corner : mesh->mesh.face(f)) *out++ = corner.value();
}

}  // namespace
}  // namespace crowdbench::scene::draco_module

extern "C" __attribute__((visibility("default"))) const crowdbench::scene::draco_module::Api* crowdbench_draco_api() {
  using namespace crowdbench::scene::draco_module;
  static const Api api = {kApiVersion,
                          decode,
                          [](const Mesh* mesh) { return uint32_t{mesh->mesh.num_points()}; },
                          [](const Mesh* mesh) { return uint32_t{mesh->mesh.num_faces()}; },
                          attribute,
                          indices,
                          [](Mesh* mesh) { delete mesh; }};
  return &api;
}
