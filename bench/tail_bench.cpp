// Tails of the estimators of layered materials: how noisy single estimates are, and how far the largest lies
// from the mean, between directions up to the horizon and off the lobes.
//
// usage: tail_bench [--samples N] [--estimators A,B,...] [--vertices N] [--queries] [--table] [STACK...]
//   --samples N     estimates of each estimator at each pair of directions, default 100,000
//   --estimators    default: all but the two whose noise is that of plain walks
//   --vertices N    of paths at most; 3 is the shortest path under one coat. Default: all
//   --queries       a line for each pair of directions
//   --table         the stacks of the truth tests as well
// A STACK is a part of a name. Prints for each stack and estimator
//   ratio     relative standard deviation over that of "bidirectional", at the worst pair of directions
//   largest   the largest estimate over the mean, at the worst pair
// and with --queries mean, deviation and largest estimate of each pair.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <sstream>

#include "layered/tails.h"
#include "pbrt/core/rng.h"

namespace lacquer {
namespace {

using namespace layered::test;

struct Options {
    int numSamples = 100000, maxVertices = layered::kMaxPathVertices;
    std::vector<std::string> estimators = {"pairproduct", "multiproduct", "halfvector", "auto"}, stacks;
    bool showsQueries = false, usesTable = false;
};

Options ParseOptions(std::span<char*> words) {
    Options o;
    for (size_t i = 1; i < words.size(); ++i) {
        const std::string word = words[i];
        const bool hasValue = i + 1 < words.size();
        if (word == "--samples" && hasValue) {
            o.numSamples = std::max(1, std::atoi(words[++i]));
        } else if (word == "--vertices" && hasValue) {
            o.maxVertices = std::max(2, std::atoi(words[++i]));
        } else if (word == "--estimators" && hasValue) {
            o.estimators.clear();
            std::istringstream list(words[++i]);
            for (std::string name; std::getline(list, name, ',');) o.estimators.push_back(name);
        } else if (word == "--queries") {
            o.showsQueries = true;
        } else if (word == "--table") {
            o.usesTable = true;
        } else {
            o.stacks.push_back(word);
        }
    }
    return o;
}

bool IsWanted(const StackCase& row, const Options& o) {
    return o.stacks.empty() || std::any_of(o.stacks.begin(), o.stacks.end(), [&](const std::string& part) {
               return row.name.find(part) != std::string::npos;
           });
}

/// The worst of one estimator on one stack.
struct Worst {
    double ratio = 0, largest = 0;
    std::string atRatio, atLargest;

    void Add(const TailQuery& query, const Tail& tail, const Tail& yardstick) {
        const double r = yardstick.deviation > 0 ? tail.deviation / yardstick.deviation : 0;
        if (r > ratio) {
            ratio = r;
            atRatio = query.name;
        }
        if (tail.largest > largest) {
            largest = tail.largest;
            atLargest = query.name;
        }
    }
};

void RunStack(const StackCase& row, const Options& o) {
    Arena arena;
    const layered::Stack stack = row.Build(arena);
    std::vector<std::string> names = {"bidirectional"};
    names.insert(names.end(), o.estimators.begin(), o.estimators.end());
    std::vector<Worst> worst(names.size());
    for (const TailQuery& query : TailQueriesOf(stack)) {
        Tail yardstick;
        for (size_t i = 0; i < names.size(); ++i) {
            const Tail tail =
                MeasureTail(*FindEstimator(names[i]), stack, query, o.maxVertices, o.numSamples, Hash(1));
            if (i == 0) yardstick = tail;
            worst[i].Add(query, tail, yardstick);
            if (o.showsQueries)
                fmt::print("{:<28} {:<16} {:<14} mean {:9.3g}  deviation {:8.3f}  largest {:8.1f}\n",
                           row.name, query.name, names[i], tail.mean, tail.deviation, tail.largest);
        }
    }
    for (size_t i = 0; i < names.size(); ++i)
        fmt::print("{:<28} {:<14} ratio {:7.2f} at {:<16} largest {:8.1f} at {}\n", row.name, names[i],
                   worst[i].ratio, worst[i].atRatio, worst[i].largest, worst[i].atLargest);
    std::fflush(stdout);
}

}  // namespace
}  // namespace lacquer

int main(int argc, char** argv) {
    using namespace lacquer;
    try {
        const Options options = ParseOptions({argv, size_t(argc)});
        for (const StackCase& row : ProductStackCases())
            if (IsWanted(row, options)) RunStack(row, options);
        if (options.usesTable)
            for (const StackCase& row : StackCases())
                if (IsWanted(row, options)) RunStack(row, options);
        return 0;
    } catch (const std::exception& error) {
        fmt::print(stderr, "tail_bench: {}\n", error.what());
        return 1;
    }
}
