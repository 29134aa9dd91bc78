// What the report of `lacquer bulk` says in words.
#pragma once

#include <string>
#include <vector>

#include "bulk/table/bulk_computation.h"
#include "bulk/table/oriented_computation.h"

namespace lacquer::cmd {

/// Names of species: "fat + casein".
std::string NamesOfSpecies(const bulk::EnsembleComputation& computation);
/// Diameter of the ball of an ensemble times sigma_t at a wavelength; 0 without a ball.
double OpticalDepthOfBall(const bulk::BulkComputation& computation, const BulkTable& table,
                          size_t wavelength);

/// Standard error of the table's g, of the method Clusters.
double ErrorOfG(const bulk::BulkComputation& computation, const BulkTable& table, size_t wavelength);

/// What was computed.
std::string SummaryOf(const bulk::EnsembleComputation& computation, const BulkHead& table);
/// How accurate it is, in a sentence or two.
std::string VerdictOn(const bulk::BulkComputation& computation, const BulkTable& table);
std::string VerdictOn(const bulk::OrientedComputation& computation, const OrientedBulkTable& table);
/// What makes the result wrong by more than its standard errors say.
std::vector<std::string> CaveatsOf(const bulk::BulkComputation& computation, const BulkTable& table);
std::vector<std::string> CaveatsOf(const bulk::OrientedComputation& computation);

}  // namespace lacquer::cmd
