// Tables of measured reflectances.
#include "estimate/layered/measurement.h"
#include "fuzz/fuzz_target.h"

namespace lacquer::fuzz {
namespace {

void MeasurementFile(std::string_view bytes) {
    const InputFile file(bytes);
    estimate::ReadDirections(file.Path());
    const estimate::Measurement measurement = estimate::ReadMeasurement(file.Path());
    const std::string text = estimate::MeasurementCsv(measurement, false);
    Require(estimate::ReadMeasurement(InputFile(text).Path()).NumRows() == measurement.NumRows(),
            "a table that is written is read again");
}

}  // namespace

LACQUER_REGISTER(FuzzTargetKind, "measurement", MeasurementFile);

}  // namespace lacquer::fuzz
