// Explore on a real pair: how many embeddings it finds, how much any two of them differ, and how long it takes, as JSON.
// Usage: TRANSFORMABLES_SHARED=DIR explore_pair TARGET CHARACTER COUNT; the characters are those that tests/native/write_characters.py has written.
#include <tbb/info.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <iostream>

#include "embedding/difference.h"
#include "embedding/embedding.h"
#include "embedding/evaluator.h"
#include "embedding/search.h"
#include "pairs.h"

namespace {

using namespace transformables;

constexpr int kResolution = 64;

/// The least share of voxels that change bone between any two, mirror images being equal; 1 for a single one.
double least_difference(const reference::Case& made, const std::vector<Embedding>& found) {
  const auto voxels = std::make_shared<const Voxels>(made.target);
  Evaluator evaluator(made.character, made.target, voxels, {});
  const PartitionDifference difference(made.character, made.target, *voxels);
  std::vector<Partition> partitions(found.size());
  double least = 1;
  for (std::size_t k = 0; k < found.size(); ++k) {
    evaluator(found[k].pose, found[k].morphology);
    evaluator.read_partition(partitions[k]);
    for (std::size_t j = 0; j < k; ++j) least = std::min(least, difference(partitions[j], partitions[k]));
  }
  return least;
}

}  // namespace

int main(int count, char** words) try {
  if (count != 4 || !std::getenv("TRANSFORMABLES_SHARED")) {
    std::cerr << "usage: TRANSFORMABLES_SHARED=DIR explore_pair TARGET CHARACTER COUNT\n";
    return 2;
  }
  const reference::Case made = pairs::made({words[1], words[2]}, kResolution);
  const auto began = std::chrono::steady_clock::now();
  const std::clock_t began_cpu = std::clock();
  ExploreOptions wanted;
  wanted.count = std::atoi(words[3]);
  const std::vector<Embedding> found = explore(made.character, made.target, {}, wanted, {});
  const double cpu = double(std::clock() - began_cpu) / CLOCKS_PER_SEC;
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - began;
  double loads[1] = {0};
  if (getloadavg(loads, 1) != 1) loads[0] = -1;
  const double step = made.target.distance.shape.step;
  const auto sound = std::count_if(found.begin(), found.end(), [&](const Embedding& e) { return is_sound(e, step); });
  std::cout << "{\"pair\": \"" << made.name << "\", \"wanted\": " << wanted.count << ", \"found\": " << found.size() << ", \"sound\": " << sound
            << ", \"least_difference_pct\": " << 100 * least_difference(made, found) << ", \"best\": " << found.front().value << ", \"last\": " << found.back().value
            << ", \"seconds\": " << wall.count() << ", \"cpu_seconds\": " << cpu << ", \"cores\": " << tbb::info::default_concurrency() << ", \"load\": " << loads[0] << "}\n";
} catch (const std::exception& error) {
  std::cerr << "explore_pair: " << error.what() << "\n";
  return 1;
}
