// Assimp behind the interface of assimp_api.h: FBX and COLLADA bytes to a glTF document.
//
// Assimp's importers take a file's word for much, and nothing here can keep them from crashing on one that was made for
// it; the caller runs this in a process of its own. What is done: only the two importers are there at all, no other
// file can be opened, of Assimp's own steps after import only the cutting of polygons into triangles runs, and every
// count, index and pointer of the scene is checked before it is used.
#include <assimp/BaseImporter.h>
#include <assimp/config.h>
#include <assimp/importerdesc.h>
#include <assimp/postprocess.h>

#include <algorithm>
#include <assimp/DefaultLogger.hpp>
#include <assimp/IOStream.hpp>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <assimp/LogStream.hpp>
#include <cstring>
#include <memory>
#include <new>

#include "scene/assimp/module/conversion.h"
#include "scene/assimp/module/source_check.h"

namespace crowdbench::scene::assimp_module {
namespace {

class MemoryStream : public Assimp::IOStream {
 public:
  MemoryStream(const uint8_t* bytes, size_t size) : bytes_(bytes), size_(size) {}

  size_t Read(void* out, size_t size, size_t count) override {
    if (size == 0) return 0;
    const size_t whole = std::min(count, (size_ - at_) / size);
    std::memcpy(out, bytes_ + at_, whole * size);
    at_ += whole * size;
    return whole;
  }
  size_t Write(const void* /*from*/, size_t /*size*/, size_t /*count*/) override { return 0; }
  aiReturn Seek(size_t offset, aiOrigin origin) override {
    const size_t from = origin == aiOrigin_SET ? 0 : origin == aiOrigin_CUR ? at_ : size_;
    if (offset > size_ - from) return aiReturn_FAILURE;
    at_ = from + offset;
    return aiReturn_SUCCESS;
  }
  size_t Tell() const override { return at_; }
  size_t FileSize() const override { return size_; }
  void Flush() override {}

 private:
  const uint8_t* bytes_;
  size_t size_;
  size_t at_ = 0;
};

// One file, from memory; there is no other.
class OneFile : public Assimp::IOSystem {
 public:
  OneFile(std::string name, const uint8_t* bytes, size_t size) : name_(std::move(name)), bytes_(bytes), size_(size) {}

  bool Exists(const char* file) const override { return name_ == file; }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* file, const char* mode) override {
    return name_ == file && mode[0] == 'r' ? new MemoryStream(bytes_, size_) : nullptr;
  }
  void Close(Assimp::IOStream* stream) override { delete stream; }

 private:
  std::string name_;
  const uint8_t* bytes_;
  size_t size_;
};

void keep_only(Assimp::Importer& importer, const std::string& extension) {
  std::vector<Assimp::BaseImporter*> others;
  for (size_t i = 0; i < importer.GetImporterCount(); ++i) {
    const aiImporterDesc* about = importer.GetImporterInfo(i);
    const std::string extensions = about && about->mFileExtensions ? about->mFileExtensions : "";
    if ((" " + extensions + " ").find(" " + extension + " ") == std::string::npos)
      others.push_back(importer.GetImporter(i));
  }
  for (Assimp::BaseImporter* other : others) {
    importer.UnregisterLoader(other);
    delete other;
  }
}

std::string one_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

// What Assimp complains of and goes on without: an object, a list.
class Complaints : public Assimp::LogStream {
 public:
  explicit Complaints(std::vector<std::string>& out) : out_(out) {}
  void write(const char* message) override {
    constexpr size_t kMost = 8;
    std::string line = one_line(message);
    if (const size_t at = line.find("T0: "); at != std::string::npos) line.erase(0, at + 4);
    if (out_.size() < kMost && std::find(out_.begin(), out_.end(), line) == out_.end()) out_.push_back(line);
  }

 private:
  std::vector<std::string>& out_;
};

// In a process of its own, so that there is no other logger.
void listen(std::vector<std::string>& complaints) {
  Assimp::DefaultLogger::create("", Assimp::Logger::NORMAL, 0);
  Assimp::DefaultLogger::get()->attachStream(new Complaints(complaints), Assimp::Logger::Err);
}

void check_source(const Request& request) {
  if (request.format == Format::fbx)
    check_fbx({request.bytes, request.size});
  else
    check_collada({reinterpret_cast<const char*>(request.bytes), request.size});
}

const aiScene& import(Assimp::Importer& importer, const Request& request) {
  const std::string extension = request.format == Format::fbx ? "fbx" : "dae";
  const std::string name = "character." + extension;
  keep_only(importer, extension);
  importer.SetIOHandler(new OneFile(name, request.bytes, request.size));
  // FBX nodes have pivots and rotations before and after their own. Kept as nodes, they pose exactly; folded into one
  // node, animations would still name the kept ones.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_PRESERVE_PIVOTS, true);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_READ_CAMERAS, true);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_READ_LIGHTS, true);
  const aiScene* scene = importer.ReadFile(name, aiProcess_Triangulate);
  if (scene) return *scene;
  const std::string reason = one_line(importer.GetErrorString());
  if (reason.find("bad_alloc") != std::string::npos) throw std::bad_alloc();
  throw Refusal{"is not read by Assimp: " + (reason.empty() ? "it says no reason" : reason)};
}

std::vector<uint8_t> converted(const aiScene& scene, const Request& request) {
  check_scene(scene, request.limits);
  Conversion c(scene, request);
  convert_nodes(c);
  convert_materials(c);
  convert_meshes(c);
  convert_animations(c);
  find_lost(c);
  if (!c.lost.empty()) c.warn(fmt::format("lost, as nothing here shows it: {}", fmt::join(c.lost, ", ")));
  return c.glb.container();
}

void convert(const Request* request) {
  try {
    check_source(*request);
    std::vector<std::string> complaints;
    listen(complaints);
    Assimp::Importer importer;
    const std::vector<uint8_t> glb = converted(import(importer, *request), *request);
    for (const std::string& line : complaints) {
      const std::string text = "what Assimp complains of is left out: " + line;
      request->write(request->context, Item::warning, text.data(), text.size());
    }
    request->write(request->context, Item::glb, reinterpret_cast<const char*>(glb.data()), glb.size());
  } catch (const Refusal& refusal) {
    request->write(request->context, Item::refusal, refusal.text.data(), refusal.text.size());
  }
}

}  // namespace

std::string shown(const std::string& name) {
  constexpr size_t kMost = 60;
  if (name.empty()) return "(unnamed)";
  const std::string line = one_line(name);
  return line.size() <= kMost ? line : line.substr(0, kMost) + "...";
}

}  // namespace crowdbench::scene::assimp_module

extern "C" __attribute__((visibility("default"))) const crowdbench::scene::assimp_module::Api* crowdbench_assimp_api() {
  using namespace crowdbench::scene::assimp_module;
  static const Api api = {kApiVersion, convert};
  return &api;
}
