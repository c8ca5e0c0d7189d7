// How many members a plain struct has: the most values that it can be initialised from.
#pragma once
#include <cstddef>
#include <utility>

namespace crowdbench::support {

struct AnyValue {
  template <typename T>
  operator T() const;  // never called: only asked for
};

template <typename Struct, size_t... I>
constexpr bool takes_values(std::index_sequence<I...>) {
  return requires { Struct{(void(I), AnyValue{})...}; };
}

template <typename Struct, size_t N = 1>
constexpr size_t field_count() {
  if constexpr (takes_values<Struct>(std::make_index_sequence<N + 1>()))
    return field_count<Struct, N + 1>();
  else
    return N;
}

}  // namespace crowdbench::support
