// Memory for planes: in pages of 2 MiB where the system has them. A picture pair of 1920 x 1080 takes 16000 pages of
// 4 KiB, whose first touch costs more than all of the arithmetic (on a virtual machine, twice as much).
#pragma once
#include <cstddef>
#include <cstdlib>
#include <new>
#include <utility>
#ifdef __linux__
#include <sys/mman.h>
#endif

namespace crowdbench::metrics::vdp {

template <typename T>
struct LargePages {
  using value_type = T;
  static constexpr size_t kPage = size_t{2} << 20U;

  LargePages() = default;
  template <typename U>
  LargePages(const LargePages<U>&) {}

  T* allocate(size_t count) {
    const size_t bytes = count * sizeof(T);
    if (bytes < kPage) return static_cast<T*>(::operator new(bytes));
    const size_t whole = (bytes + kPage - 1) / kPage * kPage;
    void* memory = std::aligned_alloc(kPage, whole);
    if (!memory) throw std::bad_alloc();
#ifdef __linux__
    madvise(memory, whole, MADV_HUGEPAGE);  // a wish: without it the pages are small
#endif
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, size_t count) {
    if (count * sizeof(T) < kPage)
      ::operator delete(memory);
    else
      std::free(memory);
  }
  // Left as it is: whoever makes a plane writes all of it.
  template <typename U>
  void construct(U* place) {
    ::new (static_cast<void*>(place)) U;
  }
  template <typename U, typename V>
  void construct(U* place, V&& value) {
    ::new (static_cast<void*>(place)) U(std::forward<V>(value));
  }
  bool operator==(const LargePages&) const { return true; }
};

}  // namespace crowdbench::metrics::vdp
