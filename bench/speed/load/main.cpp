// bench_load: what it costs to load a character, in seconds of process CPU, beside tinygltf's own parse of the same
// bytes.
//
//   bench_load [FILE.glb]    default: a figure made here, 100,000 triangles, two textures of 4096 x 4096 and a clip
//
// Both take turns in one process, so that a busy machine slows both alike; a figure is the median of the rounds, and
// the ratio that of each round. tinygltf's parse decodes the pictures as well; it checks nothing, unpacks no accessor,
// measures no motion and hashes nothing. Memory is what each takes at most beside the file's bytes, in a process of its
// own.
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <tiny_gltf.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/speed/cpu_time.h"
#include "core/error.h"
#include "core/files.h"
#include "core/random.h"
#include "scene/gltf/gltf.h"
#include "scene/mannequin/mannequin.h"

namespace {

using namespace crowdbench;
using bench::cpu_seconds;
using bench::median;

constexpr int kRounds = 7;
constexpr int kSide = 4096;
constexpr size_t kTriangles = 100'000;

// A picture that compresses as painted ones do: flat areas, slow changes and some grain.
Image8 painted(uint64_t seed) {
  Image8 out(kSide, kSide, 4);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const auto grain = random_below(seed, static_cast<uint64_t>(y) * kSide + static_cast<uint64_t>(x), 0, 8);
      for (int c = 0; c < 3; ++c)
        out.at(x, y)[c] = static_cast<uint8_t>(100 + 20 * ((x / 256 + y / 256 + c) % 5) + grain);
      out.at(x, y)[3] = 255;
    }
  return out;
}

// The mannequin, as many times over as it takes.
scene::Character dense_figure() {
  scene::Character figure = scene::make_mannequin();
  const scene::Mesh once = figure.mesh;
  scene::Mesh& mesh = figure.mesh;
  while (figure.triangles() < kTriangles) {
    const auto vertices = static_cast<uint32_t>(mesh.positions.size());
    const auto indices = static_cast<uint32_t>(mesh.indices.size());
    const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
    append(mesh.positions, once.positions);
    append(mesh.normals, once.normals);
    append(mesh.uvs, once.uvs);
    append(mesh.joints, once.joints);
    append(mesh.weights, once.weights);
    for (const uint32_t i : once.indices) mesh.indices.push_back(i + vertices);
    for (scene::Primitive primitive : once.primitives) {
      primitive.first_index += indices;
      primitive.first_vertex += vertices;
      mesh.primitives.push_back(primitive);
    }
  }
  figure.images.resize(2);
  for (size_t i = 0; i < figure.images.size(); ++i) figure.images[i].image = painted(i);
  for (size_t m = 0; m < figure.materials.size(); ++m)
    figure.materials[m].base_colour_image = static_cast<int>(m % figure.images.size());
  return figure;
}

std::vector<uint8_t> made_file() {
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / fmt::format("bench_load-{}.glb", getpid());
  scene::save_character(dense_figure(), path);
  std::vector<uint8_t> bytes = read_file(path);
  std::filesystem::remove(path);
  return bytes;
}

double parse_seconds(const std::vector<uint8_t>& bytes) {
  const double start = cpu_seconds();
  tinygltf::TinyGLTF parser;
  tinygltf::Model model;
  std::string error;
  std::string warning;
  if (!parser.LoadBinaryFromMemory(&model, &error, &warning, bytes.data(), static_cast<unsigned>(bytes.size())))
    throw Error("tinygltf", error, "name a .glb file that holds its pictures");
  return cpu_seconds() - start;
}

// The most memory that a process holds which does the work, MiB.
template <typename Work>
double peak_mib(const Work& work) {
  const pid_t child = fork();
  if (child == 0) {
    try {
      work();
      _exit(0);
    } catch (...) {
      _exit(1);
    }
  }
  int status = 0;
  rusage used{};
  if (child < 0 || wait4(child, &status, 0, &used) != child || status != 0)
    throw Error("a process of its own", "could not do the work", "look at what the other line says");
  return static_cast<double>(used.ru_maxrss) / 1024;
}

int run(int argc, char** argv) {
  const std::string name = argc > 1 ? argv[1] : "made here";
  const std::vector<uint8_t> bytes = argc > 1 ? read_file(argv[1]) : made_file();
  const double before = peak_mib([] {});
  const double our_peak = peak_mib([&] { scene::load_character(bytes, name, {}); }) - before;
  const double their_peak = peak_mib([&] { parse_seconds(bytes); }) - before;
  std::vector<double> ours;
  std::vector<double> theirs;
  std::vector<double> ratios;
  size_t triangles = 0;
  for (int round = 0; round < kRounds; ++round) {
    const double start = cpu_seconds();
    triangles = scene::load_character(bytes, name, {}).triangles();
    ours.push_back(cpu_seconds() - start);
    theirs.push_back(parse_seconds(bytes));
    ratios.push_back(ours.back() / theirs.back());
  }
  fmt::print("{}: {} bytes, {} triangles\n", name, bytes.size(), triangles);
  fmt::print("load_character {:.3f} s, tinygltf {:.3f} s of CPU; ratio {:.2f} [{:.2f}, {:.2f}] over {} rounds\n",
             median(ours), median(theirs), median(ratios), *std::ranges::min_element(ratios),
             *std::ranges::max_element(ratios), kRounds);
  fmt::print("memory at most: load_character {:.0f} MiB, tinygltf {:.0f} MiB\n", our_peak, their_peak);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const Error& error) {
    fmt::print(stderr, "bench_load: {}\n", error.what());
    return 2;
  }
}
