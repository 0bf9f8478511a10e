#include "reference/growth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

namespace transformables::reference {
namespace {

using Vec = Eigen::Vector3i;

float read(const Grid<float>& g, int i, int j, int k) {
  const Vec& n = g.shape.size;
  return g[g.shape.index(std::clamp(i, 0, n.x() - 1), std::clamp(j, 0, n.y() - 1), std::clamp(k, 0, n.z() - 1))];
}

struct Derivatives {
  double gradient = 0;   ///< |grad phi|, upwind for a front that grows (Godunov)
  double curvature = 0;  ///< divergence of the unit normal, as level set books have it: twice the geometers' mean curvature
};

Derivatives derivatives(const Grid<float>& g, const Vec& c, double speed) {
  const double h = g.shape.step;
  const int i = c.x(), j = c.y(), k = c.z();
  const double p = read(g, i, j, k);
  const std::array<double, 3> low = {read(g, i - 1, j, k), read(g, i, j - 1, k), read(g, i, j, k - 1)};
  const std::array<double, 3> high = {read(g, i + 1, j, k), read(g, i, j + 1, k), read(g, i, j, k + 1)};
  Derivatives d;
  std::array<double, 3> first{}, second{};
  double sum = 0;
  for (int a = 0; a < 3; ++a) {
    const double back = (p - low[a]) / h, ahead = (high[a] - p) / h;
    const double from_behind = speed > 0 ? std::max(back, 0.0) : std::min(back, 0.0);
    const double from_ahead = speed > 0 ? std::min(ahead, 0.0) : std::max(ahead, 0.0);
    sum += std::max(from_behind * from_behind, from_ahead * from_ahead);
    first[a] = (high[a] - low[a]) / (2 * h);
    second[a] = (high[a] - 2 * p + low[a]) / (h * h);
  }
  d.gradient = std::sqrt(sum);
  const double xy = (read(g, i + 1, j + 1, k) - read(g, i + 1, j - 1, k) - read(g, i - 1, j + 1, k) + read(g, i - 1, j - 1, k)) / (4 * h * h);
  const double xz = (read(g, i + 1, j, k + 1) - read(g, i + 1, j, k - 1) - read(g, i - 1, j, k + 1) + read(g, i - 1, j, k - 1)) / (4 * h * h);
  const double yz = (read(g, i, j + 1, k + 1) - read(g, i, j + 1, k - 1) - read(g, i, j - 1, k + 1) + read(g, i, j - 1, k - 1)) / (4 * h * h);
  const auto [x, y, z] = first;
  const double norm2 = x * x + y * y + z * z;
  if (norm2 > 1e-12) {
    const double top = second[0] * (y * y + z * z) + second[1] * (x * x + z * z) + second[2] * (x * x + y * y) -
                       2 * (x * y * xy + x * z * xz + y * z * yz);
    d.curvature = std::clamp(top / std::pow(norm2, 1.5), -1 / h, 1 / h);
  }
  return d;
}

/// Distance at a sample from its known neighbours: the quadratic of the upwind scheme.
double eikonal(std::array<double, 3> nearest, double h) {
  std::sort(nearest.begin(), nearest.end());
  double value = nearest[0] + h;
  if (value > nearest[1]) {
    const double s = nearest[0] + nearest[1], q = nearest[0] * nearest[0] + nearest[1] * nearest[1] - h * h;
    value = (s + std::sqrt(std::max(0.0, s * s - 2 * q))) / 2;
  }
  if (value > nearest[2]) {
    const double s = nearest[0] + nearest[1] + nearest[2];
    const double q = nearest[0] * nearest[0] + nearest[1] * nearest[1] + nearest[2] * nearest[2] - h * h;
    value = (s + std::sqrt(std::max(0.0, s * s - 3 * q))) / 3;
  }
  return value;
}

constexpr int kSteps[6][3] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};

/// Distance of a sample next to the front from its own value and the slope there (Russo and Smereka 2000); infinity for all others. Projection
/// against phi_0 cuts the values behind a front, so that interpolation along an edge would take the front back at every step, and fronts
/// that run along the target's surface would crawl.
double front_distance(const Grid<float>& phi, const Vec& c) {
  const double p = phi.at(c), h = phi.shape.step;
  double central2 = 0, steepest = 1e-6;
  bool beside = false;
  for (int a = 0; a < 3; ++a) {
    const Vec step(kSteps[2 * a][0], kSteps[2 * a][1], kSteps[2 * a][2]), low = c - step, high = c + step;
    const double below = read(phi, low.x(), low.y(), low.z()), above = read(phi, high.x(), high.y(), high.z());
    beside = beside || (below < 0) != (p < 0) || (above < 0) != (p < 0);
    central2 += (above - below) * (above - below) / (4 * h * h);
    steepest = std::max({steepest, std::abs(above - p) / h, std::abs(p - below) / h});
  }
  return beside ? std::abs(p) / std::max(std::sqrt(central2), steepest) : std::numeric_limits<double>::infinity();
}

void project(std::vector<Grid<float>>& phi, const Grid<float>& outer) {
  for (std::size_t v = 0; v < outer.values.size(); ++v) {
    float least = std::numeric_limits<float>::infinity(), second = least;
    for (const auto& g : phi) {
      if (g[v] < least) second = std::exchange(least, g[v]);
      else second = std::min(second, g[v]);
    }
    const float excess = least + second;
    if (excess < 0)
      for (auto& g : phi)
        if (g[v] + least < 0 || g[v] == least) g[v] -= excess / 2;
    // phi_0 wins against all; outside the target is the complement's inside.
    for (auto& g : phi) g[v] = std::max(g[v], outer[v]);
  }
}

}  // namespace

void redistance(Grid<float>& phi) {
  const GridShape& s = phi.shape;
  const double infinity = std::numeric_limits<double>::infinity();
  std::vector<double> distance(s.count(), infinity);
  std::vector<char> done(s.count(), 0);
  using Entry = std::pair<double, std::size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> front;
  for (std::size_t v = 0; v < s.count(); ++v) {
    distance[v] = front_distance(phi, s.cell(v));
    if (std::isfinite(distance[v])) front.emplace(distance[v], v);
  }
  while (!front.empty()) {
    const auto [d, v] = front.top();
    front.pop();
    if (done[v]) continue;
    done[v] = 1;
    const Vec c = s.cell(v);
    for (const auto& step : kSteps) {
      const Vec n = c + Vec(step[0], step[1], step[2]);
      if (!s.contains(n) || done[s.index(n)]) continue;
      std::array<double, 3> nearest{infinity, infinity, infinity};
      for (int a = 0; a < 3; ++a)
        for (int side = 0; side < 2; ++side) {
          const Vec m = n + Vec(kSteps[2 * a + side][0], kSteps[2 * a + side][1], kSteps[2 * a + side][2]);
          if (s.contains(m) && done[s.index(m)]) nearest[a] = std::min(nearest[a], distance[s.index(m)]);
        }
      const double value = eikonal(nearest, s.step);
      if (value < distance[s.index(n)]) {
        distance[s.index(n)] = value;
        front.emplace(value, s.index(n));
      }
    }
  }
  for (std::size_t v = 0; v < s.count(); ++v)
    if (std::isfinite(distance[v])) phi[v] = float(phi[v] < 0 ? -distance[v] : distance[v]);
}

Growth grow(const Character& character, const Target& target, const Embedding& embedding, const SegmentationOptions& options) {
  const GridShape& shape = target.distance.shape;
  const double h = shape.step, v0 = options.speed * h, dt = 0.5 / options.speed;
  const double c = options.curvature * v0 * h, kappa_0 = options.curvature_limit / h;
  const auto frames = forward_kinematics(character, embedding.pose, embedding.morphology);
  const auto shapes = skeletal_shapes(character, embedding.morphology, 0.0);
  Growth growth;
  growth.phi.assign(character.bones.size(), Grid<float>(shape, 0));
  for (std::size_t b = 0; b < shapes.size(); ++b) {
    const Eigen::Isometry3d into = frames[b].inverse();
    for (std::size_t v = 0; v < shape.count(); ++v) growth.phi[b][v] = float(shapes[b].distance(into * shape.position(v)));
  }
  for (auto& g : growth.phi) redistance(g);
  project(growth.phi, target.distance);

  std::size_t claimed = 0;
  for (int quiet = 0; claimed < target.inside.size() && quiet < 20; ++growth.steps) {
    std::vector<Grid<float>> next = growth.phi;
    for (std::size_t b = 0; b < next.size(); ++b)
      for (const std::size_t v : target.inside) {
        const Vec cell = shape.cell(v);
        const float p = growth.phi[b][v];
        float gap = std::numeric_limits<float>::infinity();
        for (std::size_t o = 0; o < next.size(); ++o)
          if (o != b) gap = std::min(gap, growth.phi[o][v]);
        const double kappa = std::abs(p) < 1.5 * h ? derivatives(growth.phi[b], cell, 1).curvature : 0;
        const double sharp = std::copysign(std::max(std::abs(kappa) - kappa_0, 0.0), kappa);
        const double free = std::max(0.0, double(p) + gap);
        const double v_i = std::min(v0 - c * sharp, free / (2 * dt));
        next[b][v] = float(p - dt * v_i * derivatives(growth.phi[b], cell, v_i).gradient);
      }
    growth.phi = std::move(next);
    for (auto& g : growth.phi) redistance(g);
    project(growth.phi, target.distance);
    const auto held = std::size_t(std::count_if(target.inside.begin(), target.inside.end(), [&](std::size_t v) {
      return std::any_of(growth.phi.begin(), growth.phi.end(), [v](const auto& g) { return g[v] <= 0; });
    }));
    quiet = held > claimed ? 0 : quiet + 1;
    claimed = std::max(claimed, held);
  }

  growth.owner.assign(shape.count(), -1);
  for (const std::size_t v : target.inside) {
    std::size_t best = 0;
    for (std::size_t b = 1; b < growth.phi.size(); ++b)
      if (growth.phi[b][v] < growth.phi[best][v]) best = b;
    growth.owner[v] = std::int16_t(best);
  }
  return growth;
}

}  // namespace transformables::reference
