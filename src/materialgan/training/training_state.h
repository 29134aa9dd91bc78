// What the files of all trainings share: states that are stored between two steps.
#pragma once

#include <initializer_list>

#include "materialgan/network/adam.h"

namespace lacquer::materialgan {

/// Of a state: which training it is and how far it has come.
struct TrainingHeader {
    std::string format;  ///< which objective
    GeneratorConfig config;
    int batch = 1;
    uint64_t seed = 1;
    int64_t steps = 0;
    double seconds = 0;  ///< of work

    std::map<std::string, std::string> ToMetadata() const;
    /// Errors: FileError for a state of another format, of other materials, or with numbers that make no
    /// sense.
    static TrainingHeader Read(const SafetensorsFile& file, const std::string& format);
};

/// The number that a state says. Errors: FileError for what is no number from 0 to `max`.
double StoredNumber(const SafetensorsFile& file, const std::string& key, double max);

/// Tensors of a state whose names have a prefix. Errors: FileError.
TensorMap ReadPrefixed(const SafetensorsFile& file, const std::string& prefix,
                       const std::vector<TensorSpec>& specs);

/// Moments, by the prefix and the number of the parameter; steps are of the header.
void AppendAdam(const Adam& adam, const std::string& prefix, std::vector<NamedTensor>* tensors);
/// Errors: FileError, also for squares below 0.
void ReadAdam(const SafetensorsFile& file, const std::string& prefix, Adam* adam);

/// All parameters of networks, in one order.
std::vector<Tensor> ParametersOf(std::initializer_list<const TensorMap*> networks);
/// Moves the averages of parameters towards what these are now. @param keep  the share that stays
void MoveAverage(const TensorMap& now, double keep, TensorMap* average);
/// What a generator's file says of its training. @param source  which training
std::map<std::string, std::string> TrainingNotes(const std::string& source, uint64_t seed, int64_t steps,
                                                 int64_t images);

/// Consecutive training materials: count x 9 x size x size.
Tensor TrainingBatch(int size, int64_t count, uint64_t seed, int64_t first);

}  // namespace lacquer::materialgan
