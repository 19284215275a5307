#include "tests/models/models.hpp"

#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "core/model/sine_cosine.hpp"

namespace contourd::models {
namespace {

struct GridPoint {
  std::array<int, 3> index;
  std::array<double, 3> at;
  double value;
};

// Returns the crossing between two grid points, computed in a fixed order, so that the vertex has the same
// bits for every tetrahedron that shares it.
Vertex crossing(const GridPoint& p, const GridPoint& q) {
  const bool in_order = p.index < q.index;
  const GridPoint& a = in_order ? p : q;
  const GridPoint& b = in_order ? q : p;
  const double t = a.value / (a.value - b.value);
  const auto mid = [&](std::size_t i) { return static_cast<float>(a.at[i] + t * (b.at[i] - a.at[i])); };
  return {mid(0), mid(1), mid(2)};
}

void add(Facets& facets, const Vertex& a, const Vertex& b, const Vertex& c) {
  if (a == b || b == c || c == a) return;
  facets.push_back({{a, b, c}});
}

// Adds the facets in a tetrahedron of positive orientation (d sees a, b, c counter-clockwise).
void march(Facets& facets, const std::array<GridPoint, 4>& t) {
  // The vertices inside, and an even permutation that brings them to the front.
  static constexpr std::array<std::array<std::size_t, 4>, 16> kOrder{{{0, 1, 2, 3},
                                                                      {0, 1, 2, 3},
                                                                      {1, 0, 3, 2},
                                                                      {0, 1, 2, 3},
                                                                      {2, 0, 1, 3},
                                                                      {2, 0, 1, 3},
                                                                      {1, 2, 0, 3},
                                                                      {3, 0, 2, 1},
                                                                      {3, 0, 2, 1},
                                                                      {0, 3, 1, 2},
                                                                      {1, 3, 2, 0},
                                                                      {2, 0, 1, 3},
                                                                      {2, 3, 0, 1},
                                                                      {1, 0, 3, 2},
                                                                      {0, 1, 2, 3},
                                                                      {0, 1, 2, 3}}};
  unsigned inside = 0;
  for (unsigned i = 0; i < 4; ++i)
    inside |= (t[i].value < 0 ? 1U : 0U) << i;
  const auto& o = kOrder[inside];
  const GridPoint &a = t[o[0]], &b = t[o[1]], &c = t[o[2]], &d = t[o[3]];
  switch (std::popcount(inside)) {
    case 1:  // a inside
      add(facets, crossing(a, b), crossing(a, c), crossing(a, d));
      break;
    case 2: {  // a and b inside
      const Vertex ac = crossing(a, c), ad = crossing(a, d), bc = crossing(b, c), bd = crossing(b, d);
      add(facets, ac, ad, bd);
      add(facets, ac, bd, bc);
      break;
    }
    case 3:  // a outside (the order brings the outer one to the front)
      add(facets, crossing(a, b), crossing(a, d), crossing(a, c));
      break;
    default:
      break;
  }
}

template <typename Value>
void append(std::byte*& at, const Value& value) {
  std::memcpy(at, &value, sizeof value);
  at += sizeof value;
}

}  // namespace

Facets box(Vertex low, Vertex high) {
  const auto corner = [&](int i) {
    return Vertex{(i & 1) != 0 ? high.x : low.x, (i & 2) != 0 ? high.y : low.y,
                  (i & 4) != 0 ? high.z : low.z};
  };
  constexpr std::array<std::array<int, 4>, 6> kFaces{
      {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
  Facets facets;
  for (const auto& f : kFaces) {
    facets.push_back({{corner(f[0]), corner(f[1]), corner(f[2])}});
    facets.push_back({{corner(f[0]), corner(f[2]), corner(f[3])}});
  }
  return facets;
}

Facets lathe(std::span<const Point> profile, int sides) {
  const auto at = [&](const Point& p, int side) {
    const double angle = 2 * std::numbers::pi * (side % sides) / sides;
    return Vertex{static_cast<float>(p.x * std::cos(angle)), static_cast<float>(p.x * std::sin(angle)),
                  static_cast<float>(p.y)};
  };
  Facets facets;
  for (std::size_t i = 0; i + 1 < profile.size(); ++i) {
    const Point &low = profile[i], &high = profile[i + 1];
    for (int side = 0; side < sides; ++side) {
      if (low.x > 0) facets.push_back({{at(low, side), at(low, side + 1), at(high, side + 1)}});
      if (high.x > 0) facets.push_back({{at(low, side), at(high, side + 1), at(high, side)}});
    }
  }
  return facets;
}

Facets cone(double radius_mm, double height_mm, int sides) {
  const Point profile[]{{0, 0}, {radius_mm, 0}, {0, height_mm}};
  return lathe(profile, sides);
}

Facets globe(double radius_mm, int bands, int sides) {
  std::vector<Point> profile{{0, -radius_mm}};
  for (int band = 1; band < bands; ++band) {
    const double angle = std::numbers::pi * band / bands;
    profile.push_back({radius_mm * std::sin(angle), -radius_mm * std::cos(angle)});
  }
  profile.push_back({0, radius_mm});
  return lathe(profile, sides);
}

Facets isosurface(const std::function<double(double, double, double)>& value, double half_side_mm,
                  int cells) {
  // Six tetrahedra around a cube's diagonal from corner 0 to 7 (bit 0 is x, 1 is y, 2 is z), the same in
  // every cube, so that neighbours' faces match.
  constexpr std::array<std::array<int, 4>, 6> kTetrahedra{
      {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}}};
  const auto points = static_cast<std::size_t>(cells) + 1;
  const auto coordinate = [&](int i) { return half_side_mm * (2.0 * i / cells - 1.0); };
  std::vector<double> lower(points * points), upper(points * points);
  const auto fill = [&](std::vector<double>& plane, int k) {
    for (int j = 0; j <= cells; ++j) {
      for (int i = 0; i <= cells; ++i) {
        const double v = value(coordinate(i), coordinate(j), coordinate(k));
        // Keeps the value off 0 at grid points: vertices exactly there would make facets without area.
        plane[static_cast<std::size_t>(j) * points + static_cast<std::size_t>(i)] = v == 0 ? 1e-12 : v;
      }
    }
  };
  Facets facets;
  fill(lower, 0);
  for (int k = 0; k < cells; ++k) {
    fill(upper, k + 1);
    for (int j = 0; j < cells; ++j) {
      for (int i = 0; i < cells; ++i) {
        std::array<GridPoint, 8> corners;
        for (int c = 0; c < 8; ++c) {
          const int x = i + (c & 1), y = j + (c >> 1 & 1), z = k + (c >> 2);
          const auto& plane = (c & 4) != 0 ? upper : lower;
          corners[static_cast<std::size_t>(c)] = {
              {x, y, z},
              {coordinate(x), coordinate(y), coordinate(z)},
              plane[static_cast<std::size_t>(y) * points + static_cast<std::size_t>(x)]};
        }
        for (const auto& t : kTetrahedra) {
          march(facets, {corners[static_cast<std::size_t>(t[0])], corners[static_cast<std::size_t>(t[1])],
                         corners[static_cast<std::size_t>(t[2])], corners[static_cast<std::size_t>(t[3])]});
        }
      }
    }
    std::swap(lower, upper);
  }
  return facets;
}

Facets sphere(double radius_mm, int cells) {
  return isosurface(
      [=](double x, double y, double z) { return std::sqrt(x * x + y * y + z * z) - radius_mm; },
      radius_mm * 1.05, cells);
}

Facets gyroid_sphere(double radius_mm, double period_mm, int cells) {
  constexpr double kHalfWall = 0.75;  // in the gyroid's value, which spans -1.5 to 1.5
  const double k = 2 * std::numbers::pi / period_mm;
  // Uses the core's sine and cosine, so that the model is the same on every machine.
  const auto turn = [=](double mm) { return sine_cosine(360.0 / period_mm * mm); };
  Facets facets = isosurface(
      [=](double x, double y, double z) {
        const auto [sx, cx] = turn(x);
        const auto [sy, cy] = turn(y);
        const auto [sz, cz] = turn(z);
        const double gyroid = sx * cy + sy * cz + sz * cx;
        const double shell = std::sqrt(x * x + y * y + z * z) - radius_mm;
        return std::fmax(std::fabs(gyroid) - kHalfWall, k * shell);
      },
      radius_mm * 1.03, cells);
  translate(facets, 0, 0, static_cast<float>(-bounds_of(facets).min_z));
  return facets;
}

void translate(Facets& facets, float x, float y, float z) {
  for (Facet& facet : facets) {
    for (Vertex& v : facet.vertices)
      v = {v.x + x, v.y + y, v.z + z};
  }
}

void invert(Facets& facets) {
  for (Facet& facet : facets)
    std::swap(facet.vertices[1], facet.vertices[2]);
}

Facets inverted(Facets facets) {
  invert(facets);
  return facets;
}

Facets together(Facets facets, const Facets& more) {
  facets.insert(facets.end(), more.begin(), more.end());
  return facets;
}

Facets together(std::initializer_list<Facets> parts) {
  Facets all;
  for (const Facets& part : parts)
    all.insert(all.end(), part.begin(), part.end());
  return all;
}

std::vector<std::byte> to_binary_stl(std::span<const Facet> facets) {
  std::vector<std::byte> bytes(84 + 50 * facets.size());
  std::byte* at = bytes.data() + 80;
  append(at, static_cast<std::uint32_t>(facets.size()));
  for (const Facet& facet : facets) {
    at += 12;  // the normal, which readers ignore
    append(at, facet.vertices);
    at += 2;
  }
  return bytes;
}

std::string to_ascii_stl(std::span<const Facet> facets) {
  std::string text = "solid model\n";
  const auto number = [&text](float value) {
    std::array<char, 32> digits;
    text += ' ';
    text.append(digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr);
  };
  for (const Facet& facet : facets) {
    text += "facet normal 0 0 0\n outer loop\n";
    for (const Vertex& v : facet.vertices) {
      text += "  vertex";
      for (const float coordinate : {v.x, v.y, v.z})
        number(coordinate);
      text += '\n';
    }
    text += " endloop\nendfacet\n";
  }
  return text + "endsolid model\n";
}

void write_binary_stl(const std::filesystem::path& path, std::span<const Facet> facets) {
  const std::vector<std::byte> bytes = to_binary_stl(facets);
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) throw std::runtime_error("cannot write " + path.string());
}

}  // namespace contourd::models
