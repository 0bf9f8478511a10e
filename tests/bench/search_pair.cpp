// The search for a folded pose on a real pair, as JSON. Usage, with TRANSFORMABLES_SHARED=DIR:
//   search_pair explore TARGET CHARACTER RESOLUTION COUNT   how many embeddings it finds, how much any two of them differ, and how long it takes
//   search_pair embed TARGET CHARACTER RESOLUTION SEEDS     for each seed: how long it takes, what it finds, and what ten times the evaluations would
// The characters are those that tests/native/write_characters.py has written.
#include <tbb/info.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <string>

#include "embedding/difference.h"
#include "embedding/embedding.h"
#include "embedding/evaluator.h"
#include "embedding/search.h"
#include "pairs.h"

namespace {

using namespace transformables;

constexpr int kMore = 10;  // times the evaluations

/// What has passed since it was made.
class Clocks {
 public:
  double wall() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - wall_).count(); }
  double cpu() const { return double(std::clock() - cpu_) / CLOCKS_PER_SEC; }

 private:
  std::chrono::steady_clock::time_point wall_ = std::chrono::steady_clock::now();
  std::clock_t cpu_ = std::clock();
};

/// The load average of the last minute, -1 when it is not known.
double load() {
  double loads[1] = {0};
  return getloadavg(loads, 1) == 1 ? loads[0] : -1;
}

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

void print_explored(const reference::Case& made, int count) {
  const Clocks clocks;
  ExploreOptions wanted;
  wanted.count = count;
  const std::vector<Embedding> found = explore(made.character, made.target, {}, wanted, {});
  const double seconds = clocks.wall(), cpu = clocks.cpu(), step = made.target.distance.shape.step;
  const auto sound = std::count_if(found.begin(), found.end(), [&](const Embedding& e) { return is_sound(e, step); });
  std::cout << "\"wanted\": " << wanted.count << ", \"found\": " << found.size() << ", \"sound\": " << sound
            << ", \"least_difference_pct\": " << 100 * least_difference(made, found) << ", \"best\": " << found.front().value << ", \"last\": " << found.back().value
            << ", \"seconds\": " << seconds << ", \"cpu_seconds\": " << cpu;
}

void print_embedded(const reference::Case& made, int seeds) {
  std::cout << "\"runs\": [";
  for (int seed = 0; seed < seeds; ++seed) {
    EmbeddingOptions options;
    options.seed = std::uint64_t(seed);
    const Clocks clocks;
    const Embedding found = embed(made.character, made.target, options, {});
    const double seconds = clocks.wall(), cpu = clocks.cpu();
    options.evaluations *= kMore;
    const Embedding later = embed(made.character, made.target, options, {});
    std::cout << (seed > 0 ? ", " : "") << "{\"seed\": " << seed << ", \"seconds\": " << seconds << ", \"cpu_seconds\": " << cpu << ", \"evaluations\": " << found.evaluations
              << ", \"value\": " << found.value << ", \"sound\": " << (is_sound(found, made.target.distance.shape.step) ? "true" : "false")
              << ", \"value_of_more\": " << later.value << "}";
  }
  std::cout << "]";
}

}  // namespace

int main(int count, char** words) try {
  const std::string what = count == 6 ? words[1] : "";
  if ((what != "explore" && what != "embed") || !std::getenv("TRANSFORMABLES_SHARED")) {
    std::cerr << "usage: TRANSFORMABLES_SHARED=DIR search_pair explore|embed TARGET CHARACTER RESOLUTION COUNT|SEEDS\n";
    return 2;
  }
  const reference::Case made = pairs::made({words[2], words[3]}, std::atoi(words[4]));
  std::cout << "{\"pair\": \"" << made.name << "\", \"resolution\": " << words[4] << ", \"load\": " << load() << ", \"cores\": " << tbb::info::default_concurrency() << ", ";
  if (what == "explore") print_explored(made, std::atoi(words[5]));
  else print_embedded(made, std::atoi(words[5]));
  std::cout << "}\n";
} catch (const std::exception& error) {
  std::cerr << "search_pair: " << error.what() << "\n";
  return 1;
}
