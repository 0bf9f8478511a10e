#include <functional>
#include <map>

#include "bindings/bindings.h"
#include "embedding/embedding.h"
#include "segmentation/edits.h"

namespace transformables::bindings {
namespace {

Symmetry symmetry_from(const std::string& word) {
  if (word == "auto") return Symmetry::kAuto;
  if (word == "on") return Symmetry::kOn;
  if (word == "off") return Symmetry::kOff;
  throw InvalidInput("symmetry is auto, on or off, not '" + word + "'");
}

py::dict terms_of(const Embedding& e) {
  const ObjectiveTerms& t = e.terms;
  py::dict d;
  d["compact"] = t.compact;
  d["skin"] = t.skin;
  d["skeleton"] = t.skeleton;
  d["protrude"] = t.protrude;
  d["limits"] = t.limits;
  d["morphology"] = t.morphology;
  d["unfold"] = t.unfold;
  d["total"] = t.total;
  return d;
}

ObjectiveWeights weights_from(const std::map<std::string, double>& given) {
  ObjectiveWeights w;
  const std::map<std::string, double*> places{{"compact", &w.compact}, {"skin", &w.skin}, {"skeleton", &w.skeleton},
                                              {"protrude", &w.protrude}, {"limits", &w.limits}, {"morphology", &w.morphology},
                                              {"unfold", &w.unfold}};
  for (const auto& [term, weight] : given) {
    const auto place = places.find(term);
    if (place == places.end()) throw InvalidInput("the objective has no term called '" + term + "'");
    *place->second = weight;
  }
  return w;
}

using Locks = std::vector<std::tuple<int, double>>;
using Pins = std::vector<std::tuple<int, std::vector<double>>>;
using Proportions = std::vector<std::tuple<int, double, double>>;

EmbeddingOptions options_from(std::uint64_t seed, const std::string& symmetry, bool proportions, int threads,
                              const std::map<std::string, double>& weights, const Locks& locked, const Pins& pinned,
                              const Proportions& proportion_of) {
  EmbeddingOptions options;
  options.seed = seed;
  options.symmetry = symmetry_from(symmetry);
  options.proportions = proportions;
  options.threads = threads;
  options.weights = weights_from(weights);
  for (const auto& [angle, radians] : locked) options.locked.push_back({angle, radians});
  for (const auto& [bone, frame] : pinned) options.pinned.push_back({bone, frame_from(frame)});
  for (const auto& [bone, least, largest] : proportion_of) options.proportion_of.push_back({bone, least, largest});
  return options;
}

/// What the artist's edits ask of the pose. A bone that the character has not is left out: the segmentation tells of it.
std::vector<PaintedRegion> painted_from(const std::vector<Edit>& edits, const Character& character) {
  std::vector<PaintedRegion> regions;
  for (const Edit& edit : edits) {
    if (edit.kind == EditKind::kKeepWhole) regions.push_back({-1, edit.painted});
    if (edit.kind != EditKind::kAssign) continue;
    for (std::size_t b = 0; b < character.bones.size(); ++b)
      if (character.bones[b].name == edit.bone) regions.push_back({int(b), edit.painted});
  }
  return regions;
}

/// Calls a Python function with an embedding; hold `callback` while it lives. None: nothing to call.
std::function<void(const Embedding&)> hearer(const py::object& callback) {
  if (callback.is_none()) return {};
  return [&callback](const Embedding& e) {
    py::gil_scoped_acquire gil;
    callback(e);
  };
}

py::dict fit_of(const Character& character, const Target& target, const Embedding& e) {
  const SkeletonFit fit = skeleton_fit(character, target, e.pose, e.morphology);
  py::list collisions;
  for (const auto& c : fit.collisions) collisions.append(py::make_tuple(c.first, c.second, c.depth));
  py::dict d;
  d["protrusion"] = fit.protrusion;
  d["collisions"] = collisions;
  return d;
}

std::vector<std::vector<double>> bone_frames(const Character& character, const Embedding& e) {
  std::vector<std::vector<double>> rows;
  for (const Eigen::Isometry3d& frame : forward_kinematics(character, e.pose, e.morphology)) rows.push_back(flat(frame));
  return rows;
}

}  // namespace

void bind_embedding(py::module_& m) {
  py::class_<Embedding>(m, "Embedding")
      .def(py::init([](const std::vector<double>& root, const std::vector<double>& angles, const std::vector<double>& morphology,
                       bool symmetric) {
             Embedding e;
             e.pose.root = frame_from(root);
             e.pose.angles = vector_from(angles);
             e.morphology = vector_from(morphology);
             e.symmetric = symmetric;
             return e;
           }),
           py::kw_only(), py::arg("root"), py::arg("angles"), py::arg("morphology"), py::arg("symmetric") = false)
      .def_property_readonly("root", [](const Embedding& e) { return flat(e.pose.root); })
      .def_property_readonly("angles", [](const Embedding& e) { return flat(e.pose.angles); })
      .def_property_readonly("morphology", [](const Embedding& e) { return flat(e.morphology); })
      .def_property_readonly("terms", &terms_of)
      .def_readonly("value", &Embedding::value)
      .def_readonly("symmetric", &Embedding::symmetric)
      .def_readonly("deepest_protrusion", &Embedding::deepest_protrusion)
      .def_readonly("deepest_collision", &Embedding::deepest_collision)
      .def_readonly("evaluations", &Embedding::evaluations)
      .def_readonly("missed", &Embedding::missed);

  m.def(
      "embed",
      [](const Character& character, const Target& target, std::uint64_t seed, const std::string& symmetry, bool proportions,
         int threads, const std::map<std::string, double>& weights, const Locks& locked, const Pins& pinned,
         const Proportions& proportion_of, const std::vector<Edit>& edits, const std::optional<Embedding>& start, const py::object& progress,
         const py::object& best, const py::object& trying) {
        EmbeddingOptions options = options_from(seed, symmetry, proportions, threads, weights, locked, pinned, proportion_of);
        options.painted = painted_from(edits, character);
        const Progress tell = progress_from(progress);
        const auto show = hearer(best);
        options.trying = hearer(trying);
        py::gil_scoped_release release;
        return embed(character, target, options, tell, start, show);
      },
      py::arg("character"), py::arg("target"), py::kw_only(), py::arg("seed") = 0, py::arg("symmetry") = "auto",
      py::arg("proportions") = true, py::arg("threads") = 0, py::arg("weights") = std::map<std::string, double>{},
      py::arg("locked") = Locks{}, py::arg("pinned") = Pins{}, py::arg("proportion_of") = Proportions{},
      py::arg("edits") = std::vector<Edit>{}, py::arg("start") = py::none(), py::arg("progress") = py::none(), py::arg("best") = py::none(),
      py::arg("trying") = py::none(),
      "Folds the fitted character's skeleton into the target (CMA-ES). weights: term -> number, for terms that are not to have the usual "
      "one; locked: (angle index, radians); pinned: (bone, its frame in the target's, 16 numbers column-major); proportion_of: (bone, least, "
      "largest scale); edits: of which those that paint regions are heeded. best(Embedding) hears of each better pose, trying(Embedding) some "
      "times a second where the search is. Raises InvalidInput, Cancelled.");

  m.def(
      "explore",
      [](const Character& character, const Target& target, std::uint64_t seed, const std::string& symmetry, bool proportions,
         int threads, const std::map<std::string, double>& weights, const Locks& locked, const Pins& pinned,
         const Proportions& proportion_of, const std::vector<Edit>& edits, int count, double least_difference, int evaluations,
         const py::object& progress, const py::object& found, const py::object& best, const py::object& trying) {
        EmbeddingOptions options = options_from(seed, symmetry, proportions, threads, weights, locked, pinned, proportion_of);
        options.painted = painted_from(edits, character);
        options.evaluations = evaluations;
        const Progress tell = progress_from(progress);
        const auto add = hearer(found), show = hearer(best);
        options.trying = hearer(trying);
        py::gil_scoped_release release;
        return explore(character, target, options, {count, least_difference}, tell, add, show);
      },
      py::arg("character"), py::arg("target"), py::kw_only(), py::arg("seed") = 0, py::arg("symmetry") = "auto",
      py::arg("proportions") = true, py::arg("threads") = 0, py::arg("weights") = std::map<std::string, double>{},
      py::arg("locked") = Locks{}, py::arg("pinned") = Pins{}, py::arg("proportion_of") = Proportions{},
      py::arg("edits") = std::vector<Edit>{}, py::arg("count") = 5, py::arg("least_difference") = 0.15,
      py::arg("evaluations") = EmbeddingOptions{}.evaluations, py::arg("progress") = py::none(), py::arg("found") = py::none(), py::arg("best") = py::none(),
      py::arg("trying") = py::none(),
      "Up to `count` embeddings that differ in over `least_difference` of the target's voxels, best first; evaluations bounds each search. found(Embedding) hears of each as "
      "it is found (some may be replaced by better ones like them); the rest as in embed. Raises InvalidInput, Cancelled.");

  m.def("skeleton_fit", &fit_of, py::arg("character"), py::arg("target"), py::arg("embedding"),
        "How far each bone's surface sticks out of the target, and which bones collide: {protrusion: one number a bone, collisions: "
        "[(bone, bone, depth)]}, target units. Raises InvalidInput.");
  m.def("bone_frames", &bone_frames, py::arg("character"), py::arg("embedding"),
        "Each bone's frame in the target's: 16 numbers, column-major. Raises InvalidInput.");
}

}  // namespace transformables::bindings
