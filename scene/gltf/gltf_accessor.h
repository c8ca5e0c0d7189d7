// Reading glTF accessors in place: strides, sparse overlays, every component type, no copy. Internal to the loader.
#pragma once
#include <cstdint>
#include <cstring>
#include <span>
#include <string>

#include "core/error.h"

namespace crowdbench::scene {

enum ComponentType : uint8_t { kI8, kU8, kI16, kU16, kU32, kF32 };

// Bytes of one component.
inline size_t component_size(ComponentType type) {
  switch (type) {
    case kI8:
    case kU8: return 1;
    case kI16:
    case kU16: return 2;
    default: return 4;
  }
}

// Pointers into bytes whose ranges were checked. A sparse accessor's indices must be strictly increasing and below
// `count` (check_sparse). Copies are cheap.
struct AccessorView {
  std::string path;               // "/accessors/3"
  const uint8_t* base = nullptr;  // nullptr: all zero
  size_t stride = 0;
  size_t count = 0;
  int components = 1;
  ComponentType type = kF32;
  bool normalized = false;
  const uint8_t* sparse_indices = nullptr;
  const uint8_t* sparse_values = nullptr;
  size_t sparse_count = 0;
  ComponentType sparse_index_type = kU32;

  size_t sparse_index(size_t i) const { return read_unsigned(sparse_indices, sparse_index_type, i); }

  // The unsigned integer of a scalar or of one component; only for kU8, kU16, kU32.
  uint32_t unsigned_at(size_t i, int c = 0) const {
    const uint8_t* p = element(i);
    return p ? read_unsigned(p, type, static_cast<size_t>(c)) : 0;
  }

  // As the specification's float: normalised integers to [0, 1] or [-1, 1], others by value.
  double at(size_t i, int c) const {
    const uint8_t* p = element(i);
    if (!p) return 0.0;
    switch (type) {
      case kF32: {
        float v = 0;
        std::memcpy(&v, p + size_t{4} * static_cast<size_t>(c), sizeof v);
        return static_cast<double>(v);
      }
      case kU8: return normalized ? p[c] / 255.0 : p[c];
      case kI8: {
        const double v = static_cast<int8_t>(p[c]);
        return normalized ? (v < -127.0 ? -1.0 : v / 127.0) : v;
      }
      case kU16: {
        const double v = read_unsigned(p, kU16, static_cast<size_t>(c));
        return normalized ? v / 65535.0 : v;
      }
      case kI16: {
        int16_t s = 0;
        std::memcpy(&s, p + size_t{2} * static_cast<size_t>(c), sizeof s);
        const double v = s;
        return normalized ? (v < -32767.0 ? -1.0 : v / 32767.0) : v;
      }
      case kU32: return read_unsigned(p, kU32, static_cast<size_t>(c));
    }
    return 0.0;
  }

 private:
  static uint32_t read_unsigned(const uint8_t* p, ComponentType t, size_t i) {
    if (t == kU8) return p[i];
    if (t == kU16) {
      uint16_t v = 0;
      std::memcpy(&v, p + 2 * i, sizeof v);
      return v;
    }
    uint32_t v = 0;
    std::memcpy(&v, p + 4 * i, sizeof v);
    return v;
  }

  const uint8_t* element(size_t i) const {
    if (sparse_count != 0) {
      size_t low = 0;
      size_t high = sparse_count;
      while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (sparse_index(middle) < i)
          low = middle + 1;
        else
          high = middle;
      }
      if (low < sparse_count && sparse_index(low) == i)
        return sparse_values + low * component_size(type) * static_cast<size_t>(components);
    }
    return base ? base + i * stride : nullptr;
  }
};

}  // namespace crowdbench::scene
