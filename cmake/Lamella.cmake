# What every target of this project has in common.

add_library(lamella_flags INTERFACE)
target_compile_options(lamella_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wold-style-cast
  -Wcast-qual -Woverloaded-virtual -Wdouble-promotion -Wformat=2 -ffp-contract=off)
if(LAMELLA_WERROR)
  # The flow-based warnings of GCC 12 fire inside library templates that are compiled with their
  # checks on; they stay warnings.
  target_compile_options(lamella_flags INTERFACE -Werror
    $<$<CXX_COMPILER_ID:GNU>:-Wno-error=array-bounds;-Wno-error=free-nonheap-object;-Wno-error=maybe-uninitialized;-Wno-error=nonnull;-Wno-error=restrict;-Wno-error=stringop-overflow;-Wno-error=stringop-overread>)
endif()
if(LAMELLA_SANITIZE)
  target_compile_options(lamella_flags INTERFACE
    -fsanitize=${LAMELLA_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=undefined
    $<$<CXX_COMPILER_ID:Clang>:-fsanitize-ignorelist=${PROJECT_SOURCE_DIR}/cmake/sanitizers.ignore>)
  target_link_options(lamella_flags INTERFACE -fsanitize=${LAMELLA_SANITIZE})
endif()
if(LAMELLA_COVERAGE)
  target_compile_options(lamella_flags INTERFACE --coverage)
  target_link_options(lamella_flags INTERFACE --coverage)
endif()
set_target_properties(lamella_flags PROPERTIES EXPORT_NAME flags)

# lamella_library(NAME sources...): the static library lamella::NAME of a folder.
# Third-party headers are system headers: their warnings are not ours.
function(lamella_library name)
  add_library(lamella_${name} STATIC ${ARGN})
  add_library(lamella::${name} ALIAS lamella_${name})
  set_target_properties(lamella_${name} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(lamella_${name} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:include/lamella>)
  target_link_libraries(lamella_${name} PRIVATE $<BUILD_INTERFACE:lamella_flags>)
endfunction()

# lamella_own_units(sources...): where sources share a unit (CMAKE_UNITY_BUILD in the presets), these
# don't: kernels that Highway compiles once per instruction set include themselves again, and a
# replaced operator new is for the linker only.
function(lamella_own_units)
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()
