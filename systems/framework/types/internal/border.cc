#include <tenon/systems/framework/types/internal/border.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>

#ifdef TENON_ADOPTS_EIGEN_MEMORY
extern "C" void __real_free(void* memory);  // NOLINT: free itself, see adopt_eigen_memory.cc
#endif

namespace tenon {

namespace the_library_does_not_fit_this_program_in_which {

template <int>
void GLIBCXX_DEBUG_is() {}
template <int>
void GLIBCXX_USE_CXX11_ABI_is() {}
template <int, int>
void the_version_of_Eigen_is() {}
template <int>
void the_size_of_Eigen_Index_is() {}
template <int>
void EIGEN_DEFAULT_TO_ROW_MAJOR_is() {}
template <int>
void EIGEN_MAX_STATIC_ALIGN_BYTES_is() {}
template <int>
void EIGEN_MAX_ALIGN_BYTES_is() {}
template <int>
void EIGEN_MALLOC_ALREADY_ALIGNED_is() {}

template void GLIBCXX_DEBUG_is<internal::kGlibcxxDebug>();
template void GLIBCXX_USE_CXX11_ABI_is<internal::kCxx11Abi>();
template void the_version_of_Eigen_is<EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION>();
template void the_size_of_Eigen_Index_is<sizeof(Eigen::Index)>();
template void EIGEN_DEFAULT_TO_ROW_MAJOR_is<internal::kRowMajor>();
// The program's objects must have at least the alignment that the library assumes.
template void EIGEN_MAX_STATIC_ALIGN_BYTES_is<EIGEN_MAX_STATIC_ALIGN_BYTES>();
#if EIGEN_MAX_STATIC_ALIGN_BYTES < 32
template void EIGEN_MAX_STATIC_ALIGN_BYTES_is<32>();
#endif
#if EIGEN_MAX_STATIC_ALIGN_BYTES < 64
template void EIGEN_MAX_STATIC_ALIGN_BYTES_is<64>();
#endif
template void EIGEN_MAX_ALIGN_BYTES_is<EIGEN_MAX_ALIGN_BYTES>();
template void EIGEN_MALLOC_ALREADY_ALIGNED_is<internal::kEigenUsesMalloc>();
#ifdef TENON_ADOPTS_EIGEN_MEMORY
#if EIGEN_MAX_ALIGN_BYTES == 16 && EIGEN_MALLOC_ALREADY_ALIGNED
template void EIGEN_MAX_ALIGN_BYTES_is<0>();
template void EIGEN_MAX_ALIGN_BYTES_is<32>();
template void EIGEN_MAX_ALIGN_BYTES_is<64>();
template void EIGEN_MALLOC_ALREADY_ALIGNED_is<0>();
#endif
#endif

}  // namespace the_library_does_not_fit_this_program_in_which

namespace internal {

std::atomic<bool> eigen_memory_is_adopted = false, eigen_memory_is_in_use = false;

int AdoptEigenMemory() {
  if (kEigenUsesMalloc != 0 && !eigen_memory_is_adopted.exchange(true) && eigen_memory_is_in_use) {
    std::fputs(
        "tenon: code whose Eigen does not use malloc (-mavx, -march=native, a sanitizer) was loaded after "
        "other "
        "code had already used Tenon: compile both with the same options\n",
        stderr);
    std::abort();
  }
  return 1;
}

void FreeMalloced(void* memory) {
#ifdef TENON_ADOPTS_EIGEN_MEMORY
  __real_free(memory);
#else
  std::free(memory);
#endif
}

}  // namespace internal
}  // namespace tenon
