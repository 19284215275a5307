#include "core/contour/open_chain_joiner.hpp"

#include "tests/catch.hpp"
#include "tests/core/near.hpp"
#include "tests/random_shapes.hpp"

namespace {

constexpr Millimeters kJoinTolerance{0.05};

struct OpenChain {
  Point start, end;
  std::uint32_t weight = 2;
};

JoinedChains joined(const std::vector<OpenChain>& chains, Millimeters tolerance = kJoinTolerance) {
  OpenChainJoiner joiner;
  joiner.reset(tolerance);
  for (const OpenChain& chain : chains)
    joiner.add(chain.start, chain.end, chain.weight);
  MaskBudget unlimited;
  return joiner.join(unlimited);
}

// Checks that every chain is in exactly one loop, once.
bool every_chain_once(const JoinedChains& result, std::size_t chains) {
  std::vector<int> uses(chains, 0);
  std::uint32_t next = 0;
  for (const JoinedChains::Loop& loop : result.loops) {
    if (loop.first != next || loop.count == 0) return false;
    next += loop.count;
  }
  if (next != result.links.size()) return false;
  for (const JoinedChains::Link& link : result.links)
    ++uses.at(link.chain);
  return std::ranges::all_of(uses, [](int n) { return n == 1; });
}

std::vector<OpenChain> draw_chains(std::int64_t most, double reach) {
  std::vector<OpenChain> chains(static_cast<std::size_t>(testing::draw(1, most)));
  for (OpenChain& chain : chains) {
    const auto point = [reach] { return Point{testing::draw_real(0, reach), testing::draw_real(0, reach)}; };
    chain = {point(), point(), static_cast<std::uint32_t>(testing::draw(2, 100))};
  }
  return chains;
}

}  // namespace

TEST_CASE("No chains give no loops") {
  const JoinedChains result = joined({});
  CHECK(result.loops.empty());
  CHECK(result.links.empty());
  CHECK(result.cracks.open_chains == 0);
}

TEST_CASE("Ends that nearly meet are joined, others are closed as a guess, and either is counted") {
  struct Row {
    const char* what;
    std::vector<OpenChain> chains;
    std::uint32_t gaps_closed, open_chains;
    double widest_gap;
    Millimeters tolerance = kJoinTolerance;
  };
  for (const Row& row : {
           Row{"a chain whose ends nearly meet", {{{0, 0}, {0.001, 0}}}, 1, 0, 0.001},
           Row{"a gap of just the tolerance", {{{0, 0}, {0.05, 0}}}, 1, 0, 0.05},
           Row{"one just above it", {{{0, 0}, {std::nextafter(0.05, 1.0), 0}}}, 0, 1, 0.05},
           Row{"a chain whose ends are too far apart", {{{0, 0}, {3, 4}}}, 0, 1, 5},
           Row{"the very same points are no gap", {{{0, 0}, {10, 0}}, {{0, 0}, {10, 0}}}, 0, 0, 0},
           Row{"a join and a guess", {{{0, 0}, {10, 0}}, {{10, 0.01}, {10, 10}}}, 1, 1, std::hypot(10, 10)},
           Row{"no tolerance", {{{0, 0}, {10, 0}}, {{10, 0}, {20, 0}}}, 0, 1, 20, Millimeters{0}},
           Row{"far larger than the tolerance",
               {{{1e17, 1e17}, {3e17, 1e17}}, {{3e17, 1e17}, {1e17, 1e17}}},
               0,
               0,
               0},
       }) {
    CAPTURE(row.what);
    const JoinedChains result = joined(row.chains, row.tolerance);
    REQUIRE(result.loops.size() == 1);
    CHECK(result.loops[0].repaired == (row.open_chains > 0));
    CHECK(result.cracks.gaps_closed == row.gaps_closed);
    CHECK(result.cracks.open_chains == row.open_chains);
    CHECK(near(result.cracks.widest_gap.count(), row.widest_gap));
  }
  CHECK_FALSE(joined({{{0, 0}, {0.001, 0}}}).links[0].reversed);
}

TEST_CASE("Chains follow each other head to tail") {
  const JoinedChains result =
      joined({{{0, 0}, {10, 0}}, {{10, 10}, {0, 10}}, {{0, 10.001}, {0, 0.002}}, {{10, 0.003}, {10, 9.999}}});
  REQUIRE(result.loops.size() == 1);
  CHECK(result.loops[0].count == 4);
  CHECK(result.cracks.gaps_closed == 4);
  CHECK(result.cracks.open_chains == 0);
  std::vector<std::uint32_t> order;
  for (const JoinedChains::Link& link : result.links) {
    CHECK_FALSE(link.reversed);
    order.push_back(link.chain);
  }
  CHECK(order == std::vector<std::uint32_t>{0, 3, 1, 2});
}

TEST_CASE("The heaviest of chains that disagree sets the loop's direction") {
  for (const std::uint32_t heavy : {0U, 1U}) {
    std::vector<OpenChain> chains{{{0, 0}, {10, 0}, 2}, {{0, 0}, {10, 0}, 2}};
    chains[heavy].weight = 9;
    const JoinedChains result = joined(chains);
    REQUIRE(result.links.size() == 2);
    for (const JoinedChains::Link& link : result.links)
      CHECK(link.reversed == (link.chain != heavy));
    CHECK(result.cracks.turned_chains == 1);
  }
}

TEST_CASE("The nearest ends are joined first") {
  // The first chain's end has two starts within reach; the nearer one is the third chain's.
  const JoinedChains result = joined({{{-10, 0}, {0, 0}}, {{0.04, 0}, {10, 5}}, {{0.01, 0}, {10, -5}}});
  const auto first = std::ranges::find(result.links, 0U, &JoinedChains::Link::chain);
  REQUIRE(first != result.links.end());
  const auto after = std::next(first) == result.links.end() ? result.links.begin() : std::next(first);
  CHECK(after->chain == 2);
}

TEST_CASE("A turned chain is walked backwards unless it can be closed the right way round nearby") {
  // Both begin at the left, 1 mm apart, and end at the right; the right way round, the join is as long as the
  // chains.
  const auto any_reversed = [](double length) {
    const JoinedChains result = joined({{{0, 0}, {length, 0}, 9}, {{0, 1}, {length, 1}, 3}});
    CHECK(result.links.front().chain == 0);
    return std::ranges::any_of(result.links, &JoinedChains::Link::reversed);
  };
  CHECK(any_reversed(8.1));
  CHECK_FALSE(any_reversed(3.9));
}

TEST_CASE("A ring of correct and turned chains closes without a bridge in any alternation") {
  CHECK(rc::check([] {
    const auto count = static_cast<std::size_t>(testing::draw(2, 24));
    std::vector<Point> corners(count);
    for (Point& corner : corners)
      corner = {testing::draw_real(0, 100), testing::draw_real(0, 100)};
    std::vector<OpenChain> chains;
    for (std::size_t i = 0; i < count; ++i) {
      const Point &a = corners[i], &b = corners[(i + 1) % count];
      chains.push_back(testing::draw(0, 1) == 0 ? OpenChain{a, b} : OpenChain{b, a});
    }
    for (std::size_t i = count; i > 1; --i)
      std::swap(chains[i - 1], chains[static_cast<std::size_t>(testing::draw(0, static_cast<int>(i) - 1))]);
    const JoinedChains result = joined(chains);
    RC_ASSERT(every_chain_once(result, count));
    RC_ASSERT(result.cracks.widest_gap == Millimeters{0});
    RC_ASSERT(result.cracks.open_chains == 0U);
    RC_ASSERT(result.cracks.gaps_closed == 0U);
  }));
}

TEST_CASE("A chain with only one end beside an end of the same kind is not turned") {
  const JoinedChains result = joined({{{-90, 0}, {0, 0}, 9}, {{0, 90}, {0, 1}, 9}});
  CHECK(std::ranges::none_of(result.links, &JoinedChains::Link::reversed));
}

TEST_CASE("An end that loses its start to another end is joined to a new one") {
  // Chains of 30 um with gaps of 40 um between them: joining the nearest first closes each chain on itself
  // and leaves their contour open for 1.4 mm.
  std::vector<OpenChain> chains{{{1.44, 0}, {0, 0}, 100}};
  for (int i = 0; i < 20; ++i) {
    const double x = 0.04 + 0.07 * i;
    chains.push_back({{x, 0}, {x + 0.03, 0}, 9});
  }
  const JoinedChains result = joined(chains);
  CHECK(result.loops.size() == 1);
  CHECK(result.cracks.widest_gap.count() <= 0.05);
  CHECK(result.cracks.gaps_closed == 21);
}

TEST_CASE("A short segment among cracks is not closed on itself") {
  // 20 um long between gaps of 30 um.
  const JoinedChains result =
      joined({{{0, 0}, {10, 0}, 9}, {{10.03, 0}, {10.05, 0}}, {{10.08, 0}, {0, 0}, 9}});
  CHECK(result.loops.size() == 1);
  CHECK(result.cracks.gaps_closed == 2);
  CHECK(result.cracks.open_chains == 0);
  // Alone, it is closed on itself.
  CHECK(joined({{{0, 0}, {0.02, 0}}, {{50, 0}, {50.02, 0}}}).loops.size() == 2);
}

TEST_CASE("Two loops far from each other stay separate") {
  const JoinedChains result = joined({{{0, 0}, {0, 0.01}, 3}, {{50, 0}, {50, 1}, 3}});
  CHECK(result.loops.size() == 2);
  CHECK(result.cracks.open_chains == 1);
  CHECK(std::ranges::count_if(result.loops, [](const auto& loop) { return loop.repaired; }) == 1);
}

TEST_CASE("Each of any chains becomes part of one loop") {
  CHECK(rc::check([] {
    const double reach = testing::draw(0, 1) == 0 ? 100.0 : 0.2;
    const std::vector<OpenChain> chains = draw_chains(40, reach);
    const JoinedChains result = joined(chains);
    RC_ASSERT(every_chain_once(result, chains.size()));
    RC_ASSERT(result.cracks.open_chains <= chains.size());
    const bool any_repaired =
        std::ranges::any_of(result.loops, [](const auto& loop) { return loop.repaired; });
    RC_ASSERT(any_repaired == (result.cracks.open_chains > 0));
    // No join is wider than the chains lie apart.
    RC_ASSERT(result.cracks.widest_gap.count() <= std::hypot(reach, reach));
  }));
}

TEST_CASE("Too many open chains to weigh all pairs are each closed on themselves") {
  std::vector<OpenChain> chains;
  for (int i = 0; i < 5000; ++i)
    chains.push_back({{i * 1000.0, 0}, {i * 1000.0, 500}});
  // Two chains that meet count as one chain.
  chains[1].start = chains[0].end;
  const JoinedChains result = joined(chains);
  CHECK(every_chain_once(result, chains.size()));
  CHECK(result.loops.size() == 4999);
  CHECK(result.cracks.open_chains == 4999);
  CHECK(std::ranges::all_of(result.loops, [](const auto& loop) { return loop.repaired; }));
}

TEST_CASE("Thousands of chains that all end in one point are joined without weighing all pairs", "[long]") {
  std::vector<OpenChain> chains(30'000, OpenChain{{1, 1}, {1, 1}});
  const JoinedChains result = joined(chains);
  CHECK(every_chain_once(result, chains.size()));
  CHECK(result.cracks.widest_gap == Millimeters{0});
}
