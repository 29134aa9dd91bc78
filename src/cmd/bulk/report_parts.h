// What the numbers of all pages of `lacquer bulk` have, as JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bulk/table/ensemble_computation.h"
#include "cmd/bulk/report.h"

namespace lacquer::cmd {

/// Six digits, so that curves take little room.
double Short(double value);
nlohmann::ordered_json Short(const std::vector<double>& values, double scale = 1);
/// A standard error. Rounding is none: where all realisations are alike, as those of one sphere are.
double ShortError(double error, double value);
/// Value and standard error under two keys, `key` and `key`_error.
void Put(nlohmann::ordered_json* entry, const std::string& key, const bulk::ScatteringAverage::Value& value,
         double scale = 1);

/// Title, input, particles; `summary` and `verdict` are still to come.
nlohmann::ordered_json ReportHead(const bulk::EnsembleComputation& computation, const BulkHead& table,
                                  std::vector<std::string> warnings, const BulkReportContext& context);
/// Of the method Clusters: how many there were.
void PutRealizations(nlohmann::ordered_json* results, const bulk::EnsembleComputation& computation);
/// The wavelength, size parameters and degrees there.
nlohmann::ordered_json WavelengthHead(const bulk::EnsembleComputation& computation, size_t wavelength);
/// Cross sections [um^2] for each particle after so many realisations. @param k2  square of the wavenumber
nlohmann::ordered_json HistoryOf(const bulk::EnsembleComputation& computation, size_t wavelength, double k2);
/// The same particles far apart. @param angles  of its intensity [degrees]
nlohmann::ordered_json IndependentOf(const bulk::ScatteringAverage& average,
                                     const std::vector<double>& angles, double k2, double perMillimetre);
/// The first realisation: x, y, z, radius and species of each sphere; null without one.
nlohmann::ordered_json ClusterOf(const bulk::EnsembleComputation& computation);

}  // namespace lacquer::cmd
