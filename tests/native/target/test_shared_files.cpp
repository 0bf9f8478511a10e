// Targets of real files (TRANSFORMABLES_SHARED says where they are; without it nothing is tried, loudly).
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <sstream>

#include "cases.h"
#include "read_ply.h"

namespace transformables {
namespace {

// ---- files of the shared data set -------------------------------------------------------------------------------

TriangleMesh read_obj(std::istream& in) {
  TriangleMesh mesh;
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string kind, word;
    words >> kind;
    if (kind == "v") {
      double p[3];
      for (double& x : p) words >> word, x = std::strtod(word.c_str(), nullptr);
      mesh.vertices.emplace_back(p[0], p[1], p[2]);
    } else if (kind == "f") {
      std::vector<int> corners;
      while (words >> word) corners.push_back(std::atoi(word.c_str()) - 1);
      for (std::size_t c = 2; c < corners.size(); ++c) mesh.triangles.emplace_back(corners[0], corners[c - 1], corners[c]);
    }
  }
  return mesh;
}

TriangleMesh read_off(std::istream& in) {
  TriangleMesh mesh;
  std::string word;
  std::size_t vertices = 0, faces = 0, edges = 0;
  in >> word >> vertices >> faces >> edges;
  for (std::size_t v = 0; v < vertices; ++v) {
    Vector3d p;
    in >> p[0] >> p[1] >> p[2];
    mesh.vertices.push_back(p);
  }
  for (std::size_t f = 0; f < faces; ++f) {
    int n = 0;
    in >> n;
    std::vector<int> c(std::size_t(n), 0);
    for (int& i : c) in >> i;
    for (int i = 2; i < n; ++i) mesh.triangles.emplace_back(c[0], c[std::size_t(i) - 1], c[std::size_t(i)]);
  }
  return mesh;
}

TriangleMesh read_mesh(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw std::runtime_error("cannot read " + path.string());
  if (path.extension() == ".obj") return read_obj(in);
  return path.extension() == ".off" ? read_off(in) : read_ply(in);
}

/// The mesh files of a folder of the shared data set, sorted; none, loudly, when the variable is not set.
std::vector<std::filesystem::path> shared_files(const std::string& folder) {
  const char* shared = std::getenv("TRANSFORMABLES_SHARED");
  std::vector<std::filesystem::path> files;
  if (!shared) {
    std::cout << "*** SKIPPED: TRANSFORMABLES_SHARED is not set, so no file of data/" << folder << " was tried ***\n";
    return files;
  }
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(shared) / "data" / folder))
    if (entry.path().extension() != ".py") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

double seconds_of(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void print_row(const std::string& name, const Target& t, double seconds) {
  std::cout << name << ": " << seconds << " s, " << t.mesh.triangles.size() << " faces, volume " << t.volume
            << ", inside " << t.inside.size() << (t.exact_surface ? ", exact" : ", wrapped") << ", mirror "
            << (t.mirror_axis ? *t.mirror_axis : -1) << "\n";
  for (const std::string& w : t.warnings) std::cout << "    " << w << "\n";
}

// ---- real files -------------------------------------------------------------------------------------------------

TEST(SharedFiles, clean_targets_keep_their_own_surface) {
  const auto files = shared_files("targets");
  if (files.empty()) GTEST_SKIP() << "TRANSFORMABLES_SHARED is not set";
  for (const auto& file : files) {
    SCOPED_TRACE(file.filename().string());
    const TriangleMesh mesh = read_mesh(file);
    Target target;
    const double seconds = seconds_of([&] { target = target_of(mesh, 64); });
    print_row(file.filename().string(), target, seconds);
    expect_sound(target);
    expect_signs(target, 300);
    EXPECT_TRUE(target.exact_surface);
    EXPECT_NEAR(target.volume / std::pow(target.scale, 3) / signed_volume(mesh), 1, 0.01);
    EXPECT_LT(seconds, 5);
  }
}

TEST(SharedFiles, dirty_meshes_become_sound_targets_or_clear_errors) {
  const auto files = shared_files("dirty");
  if (files.empty()) GTEST_SKIP() << "TRANSFORMABLES_SHARED is not set";
  const std::vector<std::string> hopeless = {"empty.obj", "fan3_nonmanifold.obj", "flat_sheet.ply"};
  for (const auto& file : files) {
    const std::string name = file.filename().string();
    SCOPED_TRACE(name);
    const TriangleMesh mesh = read_mesh(file);
    if (std::find(hopeless.begin(), hopeless.end(), name) != hopeless.end()) {
      std::cout << name << ": " << complaint(mesh, 64) << "\n";
      continue;
    }
    Target target;
    const double seconds = seconds_of([&] { target = target_of(mesh, 64); });
    print_row(name, target, seconds);
    expect_sound(target);
    expect_signs(target, 300);
    EXPECT_LT(seconds, 20);
  }
}

}  // namespace
}  // namespace transformables
