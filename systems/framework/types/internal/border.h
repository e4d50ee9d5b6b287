#pragma once

/// @file
/// The agreement between an installed library and a program with other compiler options. Public types have no
/// vector alignment, and a shared library adopts the way in which the program's Eigen frees memory
/// (adopt_eigen_memory.cc), so instruction sets and sanitizers may differ. Options that change the layout of
/// types must not: each file that includes this header refers to functions whose names state these options,
/// and the library defines the functions for its own options only. The linker names the option that differs.

#include <Eigen/Core>

#include <string>

namespace tenon {

namespace the_library_does_not_fit_this_program_in_which {

template <int value>
void GLIBCXX_DEBUG_is();
template <int value>
void GLIBCXX_USE_CXX11_ABI_is();
template <int world, int major>
void the_version_of_Eigen_is();
template <int bytes>
void the_size_of_Eigen_Index_is();
template <int value>
void EIGEN_DEFAULT_TO_ROW_MAJOR_is();
template <int bytes>
void EIGEN_MAX_STATIC_ALIGN_BYTES_is();
template <int bytes>
void EIGEN_MAX_ALIGN_BYTES_is();
template <int value>
void EIGEN_MALLOC_ALREADY_ALIGNED_is();

}  // namespace the_library_does_not_fit_this_program_in_which

namespace internal {

#ifdef _GLIBCXX_DEBUG
inline constexpr int kGlibcxxDebug = 1;
#else
inline constexpr int kGlibcxxDebug = 0;
#endif
#ifdef _GLIBCXX_USE_CXX11_ABI
inline constexpr int kCxx11Abi = _GLIBCXX_USE_CXX11_ABI;
#else
inline constexpr int kCxx11Abi = -1;  // another standard library
#endif
inline constexpr int kRowMajor = EIGEN_DEFAULT_MATRIX_STORAGE_ORDER_OPTION == Eigen::RowMajor ? 1 : 0;
/// Whether Eigen's memory is that of malloc. Otherwise the word before it holds the pointer to free.
inline constexpr int kEigenUsesMalloc =
    EIGEN_DEFAULT_ALIGN_BYTES == 0 || EIGEN_MALLOC_ALREADY_ALIGNED != 0 ? 1 : 0;

namespace agree = the_library_does_not_fit_this_program_in_which;
[[gnu::used]] static void (*const kAgreed[])() = {
    &agree::GLIBCXX_DEBUG_is<kGlibcxxDebug>,
    &agree::GLIBCXX_USE_CXX11_ABI_is<kCxx11Abi>,
    &agree::the_version_of_Eigen_is<EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION>,
    &agree::the_size_of_Eigen_Index_is<sizeof(Eigen::Index)>,
    &agree::EIGEN_DEFAULT_TO_ROW_MAJOR_is<kRowMajor>,
    &agree::EIGEN_MAX_STATIC_ALIGN_BYTES_is<EIGEN_MAX_STATIC_ALIGN_BYTES>,
    &agree::EIGEN_MAX_ALIGN_BYTES_is<EIGEN_MAX_ALIGN_BYTES>,
    &agree::EIGEN_MALLOC_ALREADY_ALIGNED_is<kEigenUsesMalloc>,
};

/// Makes the memory of the library's Eigen objects such that a program whose Eigen does not use malloc can
/// free it, and the reverse. Has no effect on a library that is compiled like the program.
int AdoptEigenMemory();
/// Frees memory that a library of C has allocated, such as the name of a type.
void FreeMalloced(void* memory);
#if EIGEN_DEFAULT_ALIGN_BYTES != 0 && !EIGEN_MALLOC_ALREADY_ALIGNED
[[maybe_unused]] static const int kAdopted = AdoptEigenMemory();
#endif

}  // namespace internal
}  // namespace tenon
