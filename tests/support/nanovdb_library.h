// NanoVDB's headers without the warnings that they cause, with all codecs: its functions are inline, and what
// one file compiled without a codec would be linked into the others.
#pragma once

// The library's names. NOLINTBEGIN(readability-identifier-naming)
#define NANOVDB_USE_ZIP
#define NANOVDB_USE_BLOSC
// NOLINTEND(readability-identifier-naming)

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wdouble-promotion"
#pragma GCC diagnostic ignored "-Wunused-parameter"
#include <nanovdb/util/GridBuilder.h>
#include <nanovdb/util/IO.h>
#include <nanovdb/util/Primitives.h>
#include <nanovdb/util/SampleFromVoxels.h>
#pragma GCC diagnostic pop
