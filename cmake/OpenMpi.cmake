# MPI where it is found (Debian: libopenmpi-dev), without its C++ interface, which libraries of today lack. LACQUER_HAS_MPI says
# whether it is. Only src/mpi/open_mpi.cpp knows it.
set(MPI_CXX_SKIP_MPICXX ON)
find_package(MPI QUIET COMPONENTS CXX)
# Not by the target: the module makes one even where it has found nothing.
if(MPI_CXX_FOUND)
    set(LACQUER_HAS_MPI 1)
    message(STATUS "MPI ${MPI_CXX_VERSION}: ${MPI_CXX_LIBRARIES}")
else()
    set(LACQUER_HAS_MPI 0)
endif()
