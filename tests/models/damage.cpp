#include "tests/models/damage.hpp"

#include <algorithm>
#include <map>
#include <tuple>

namespace contourd::models {
namespace {

Vertex sum(const Vertex& a, const Vertex& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}

Vertex middle_of(const Vertex& a, const Vertex& b) {
  return {(a.x + b.x) / 2, (a.y + b.y) / 2, (a.z + b.z) / 2};
}

std::size_t count_of(double share, std::size_t of) {
  return std::clamp<std::size_t>(static_cast<std::size_t>(share * static_cast<double>(of)), 1, of);
}

}  // namespace

Facets soup(std::size_t count, double reach_mm, Dice& dice) {
  Facets facets(count);
  for (Facet& facet : facets) {
    for (Vertex& v : facet.vertices)
      v = dice.in_ball(reach_mm);
  }
  return facets;
}

void shake_corners(Facets& facets, double reach_mm, Dice& dice) {
  for (Facet& facet : facets) {
    for (Vertex& v : facet.vertices)
      v = sum(v, dice.in_ball(reach_mm));
  }
}

void shake_vertices(Facets& facets, double reach_mm, Dice& dice) {
  std::map<std::tuple<float, float, float>, Vertex> moved;
  for (Facet& facet : facets) {
    for (Vertex& v : facet.vertices) {
      const auto [place, is_new] = moved.try_emplace({v.x, v.y, v.z});
      if (is_new) place->second = sum(v, dice.in_ball(reach_mm));
      v = place->second;
    }
  }
}

Facets drop_facets(Facets& facets, double share, Dice& dice) {
  Facets dropped;
  for (std::size_t left = facets.empty() ? 0 : count_of(share, facets.size()); left > 0; --left) {
    std::swap(facets[dice.below(facets.size())], facets.back());
    dropped.push_back(facets.back());
    facets.pop_back();
  }
  return dropped;
}

void turn_facets(Facets& facets, double share, Dice& dice) {
  for (Facet& facet : facets) {
    if (dice.fraction() < share) std::swap(facet.vertices[0], facet.vertices[1]);
  }
}

void double_facets(Facets& facets, double share, Dice& dice) {
  const std::size_t whole = facets.size();
  for (std::size_t left = whole == 0 ? 0 : count_of(share, whole); left > 0; --left)
    facets.push_back(Facet(facets[dice.below(whole)]));
}

void double_facets_reversed(Facets& facets, double share, Dice& dice) {
  const std::size_t whole = facets.size();
  double_facets(facets, share, dice);
  for (std::size_t i = whole; i < facets.size(); ++i)
    std::swap(facets[i].vertices[0], facets[i].vertices[1]);
}

void split_sides(Facets& facets, double share, double reach_mm, Dice& dice) {
  const std::size_t whole = facets.size();
  for (std::size_t left = whole == 0 ? 0 : count_of(share, whole); left > 0; --left) {
    auto& [a, b, c] = facets[dice.below(whole)].vertices;
    const Vertex middle = sum(middle_of(a, b), dice.in_ball(reach_mm));
    const Facet other{{middle, b, c}};
    b = middle;
    facets.push_back(other);
  }
}

}  // namespace contourd::models
