// SPDX-License-Identifier: Apache-2.0
// One test text for every executor: each verb against the standard library. An executor's own file
// specialises Maker and instantiates the suite.
//
// Sizes: empty, one, around a warp (32) and a block (256), and a million and three: prime, many blocks, many
// chunks of the CPU's 4096.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "exec/gather.hpp"
#include "frame/frame.hpp"
#include "meltsim/physics/hd.hpp"
#include "pipeline/schedule.hpp"

namespace verbs_test {

using meltsim::core::CheckResult;

/// What a suite needs to know of an executor. Specialise:
///   static std::string missing()   why it cannot run here; empty when it can
///   static bool required()         then that is a failure, not a reason to skip
///   static E make()
template <class E>
struct Maker;

inline const std::vector<std::uint64_t>& sizes() {
  static const std::vector<std::uint64_t> all{0, 1, 31, 32, 33, 255, 256, 257, 1000003};
  return all;
}

/// Memory of the executor's.
template <class E, class V>
class Buffer {
 public:
  Buffer(E& ex, std::vector<V> from) : ex_(ex), size_(from.size()) {
    data_ = static_cast<V*>(ex_.allocate(std::max<std::uint64_t>(size_, 1) * sizeof(V)));
    ex_.upload(data_, from.data(), size_ * sizeof(V));
  }
  Buffer(E& ex, std::uint64_t n, V value = V{})
      : Buffer(ex, std::vector<V>(static_cast<std::size_t>(n), value)) {}
  ~Buffer() { ex_.release(data_); }
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;
  V* get() const { return data_; }
  std::vector<V> host() const {
    std::vector<V> v(size_);
    ex_.synchronize();
    ex_.download(v.data(), data_, size_ * sizeof(V));
    return v;
  }

 private:
  E& ex_;
  std::size_t size_;
  V* data_ = nullptr;
};

// --- bodies ------------------------------------------------------------------------------------------------

struct CountVisits {
  std::uint32_t* visits;
  MELTSIM_HD void operator()(std::uint64_t i) const { visits[i] += static_cast<std::uint32_t>(i) + 1u; }
};

/// The same of a stage that may have to step aside.
struct CountVisitsModestly : CountVisits {
  static constexpr bool modest = true;
};

/// A count in either half of a word.
struct InBothHalves {
  const std::uint32_t* values;
  MELTSIM_HD std::uint64_t operator()(std::uint64_t i) const {
    return std::uint64_t{values[i]} << 32 | (values[i] ^ 1u);
  }
};

struct Values {
  const std::uint32_t* from;
  MELTSIM_HD std::uint32_t operator()(std::uint64_t i) const { return from[i]; }
};

struct Sum {
  std::uint64_t n = 0;
  MELTSIM_HD static Sum combine(Sum a, Sum b) { return {a.n + b.n}; }
};

struct SumOf {
  const std::uint32_t* from;
  MELTSIM_HD Sum operator()(std::uint64_t i) const { return {from[i]}; }
};

/// A real sum: equal only if the shape of the reduction is.
struct RealSum {
  double x = 0;
  MELTSIM_HD static RealSum combine(RealSum a, RealSum b) { return {a.x + b.x}; }
};

struct InverseOf {
  const std::uint32_t* from;
  MELTSIM_HD RealSum operator()(std::uint64_t i) const { return {1.0 / (1.0 + from[i])}; }
};

/// The worst, and counts beside it; reads ahead and writes its index.
struct Worst {
  const std::uint32_t* from;
  std::uint32_t *written = nullptr, *counted = nullptr;
  using Item = std::uint32_t;
  MELTSIM_HD Item read(std::uint64_t i) const { return from[i]; }
  template <class Add>
  MELTSIM_HD CheckResult operator()(std::uint64_t i, Item value, const Add& add) const {
    written[i] += value;
    add.count(counted, value % 50u);
    return of(i);
  }
  MELTSIM_HD CheckResult of(std::uint64_t i) const {
    CheckResult r;
    r.removed = from[i] % 3u;
    r.max_speed = from[i];
    r.bad = from[i] % 97u == 3u ? 1u + from[i] % 5u : 0u;
    r.bad_id = static_cast<std::uint32_t>(i);
    r.bad_value = r.bad != 0u ? static_cast<double>(from[i]) : 0.0;
    r.excess = from[i] % 1024u;  // of whole numbers: exact in any order
    r.dense = 1u;
    return r;
  }
};

/// A sum in parts whose results are combined: 7 from every part of i, and what read says; every 97th, if asked, is bad.
template <bool Shared>
struct GatherWorst {
  const std::uint32_t* from;
  std::uint32_t* written;
  std::uint32_t* counted;
  bool some_bad;
  static constexpr bool shared = Shared;
  struct Sum {
    std::uint32_t n = 0;
    MELTSIM_HD void add(const Sum& o) { n += o.n; }
  };
  using Item = std::uint32_t;
  MELTSIM_HD Item read(std::uint64_t i) const { return from[i]; }
  MELTSIM_HD Sum part(std::uint64_t, std::uint32_t, std::uint32_t parts) const { return {420u / parts}; }
  template <class Add>
  MELTSIM_HD meltsim::core::ParticleCheck<double> finish(std::uint64_t i, const Sum& s, Item value,
                                                         const Add& add) const {
    written[i] += value + s.n;
    add.count(counted, value % 50u);
    return of(i, value);
  }
  MELTSIM_HD meltsim::core::ParticleCheck<double> of(std::uint64_t i, std::uint32_t value) const {
    meltsim::core::ParticleCheck<double> r;
    r.speed = value + 1e-7;  // not a float
    r.phi = 1.0 / (1.0 + value);
    r.excess = value % 2u * (value % 1024u);  // of those that are dense
    r.counts = value % 2u * meltsim::core::ParticleCheck<double>::dense + (value % 3u == 0u ? 1u : 0u);
    r.bad = some_bad && value % 97u == 3u ? 1u + value % 5u : 0u;
    r.bad_id = static_cast<std::uint32_t>(i);
    r.bad_value = r.bad != 0u ? static_cast<double>(value) : 0.0;
    return r;
  }
};

/// Adds to one of `bins` sums; neighbours share one when `bins` is 1.
struct AddToBins {
  std::int64_t* sums;
  std::uint32_t bins;
  template <class Add>
  MELTSIM_HD void operator()(std::uint64_t i, const Add& add) const {
    if (i % 5u == 4u) return;  // some threads are gone by then
    const auto k = static_cast<std::int64_t>(i);
    add(&sums[i % bins], (i & 1u) != 0u ? -k * 1000003 : (std::int64_t{1} << 45) + k);
  }
};

/// Lowers one of `bins` minima to 7 i + 3 and notes what was there.
struct LowerTo {
  std::uint32_t *least, *was;
  std::uint32_t bins;
  template <class Add>
  MELTSIM_HD void operator()(std::uint64_t i, const Add& add) const {
    const auto value = 7u * static_cast<std::uint32_t>(i) + 3u;
    was[i] = add.lower(&least[i % bins], value);
  }
};

/// Bucket of an item.
struct BucketOf {
  const std::uint32_t* values;
  MELTSIM_HD std::uint32_t operator()(std::uint64_t i) const { return values[i]; }
};

struct CountInto {
  const std::uint32_t* values;
  std::uint32_t* counters;
  template <class Add>
  MELTSIM_HD void operator()(std::uint64_t i, const Add& add) const {
    add.count(counters, values[i]);
  }
};
struct NoteRun {
  std::uint64_t* runs;
  MELTSIM_HD void operator()(int) const { ++*runs; }
};

/// A sum in three parts, finished into out[i].
struct PartsOf {
  static constexpr bool shared = true;
  const std::uint32_t* values;
  std::uint64_t* out;
  struct Sum {
    std::uint64_t n = 0;
    MELTSIM_HD void add(const Sum& o) { n = 10 * n + o.n; }  // tells the order of parts
  };
  MELTSIM_HD Sum part(std::uint64_t i, std::uint32_t k, std::uint32_t) const { return {values[i] + k}; }
  MELTSIM_HD void finish(std::uint64_t i, const Sum& s) const { out[i] = s.n; }
};

/// Two passes: what all parts of an item stored, joined, is there for every part of the second. Both ends first.
struct PartsThatJoin {
  static constexpr bool shared = true, ends_first = true;
  const std::uint32_t* values;
  std::uint32_t *stored, *joined;  ///< three per item, one per item
  std::uint64_t* out;
  using Sum = PartsOf::Sum;
  MELTSIM_HD Sum part(std::uint64_t i, std::uint32_t k, std::uint32_t parts) const {
    stored[3 * i + k] = values[i] + k;
    for (std::uint32_t rest = parts; rest < 3; ++rest) stored[3 * i + rest] = 0;
    return {values[i] + k};
  }
  MELTSIM_HD void join(std::uint64_t i) const {
    joined[i] = stored[3 * i] + stored[3 * i + 1] + stored[3 * i + 2];
  }
  MELTSIM_HD void more(std::uint64_t i, std::uint32_t k, std::uint32_t, Sum& s) const {
    s.n += std::uint64_t{joined[i]} * (k + 1);
  }
  MELTSIM_HD void finish(std::uint64_t i, const Sum& s) const { out[i] += s.n; }
};

/// Nine parts of the items that are wanted: none in long runs, all in others, some elsewhere.
struct PartsOfSome {
  const std::uint32_t* values;
  std::uint64_t* out;
  struct Sum {
    std::uint64_t n = 0;
    MELTSIM_HD void add(const Sum& o) { n = 10 * n + o.n; }
  };
  MELTSIM_HD bool wanted(std::uint64_t i) const {
    return i / 500u % 3u == 0u || (i / 500u % 3u == 1u && values[i] % 3u == 0u);
  }
  MELTSIM_HD Sum part(std::uint64_t i, std::uint32_t k, std::uint32_t) const { return {values[i] % 7u + k}; }
  MELTSIM_HD void finish(std::uint64_t i, const Sum& s) const { out[i] += s.n; }
};

/// Three integers per row; every fifth item belongs to none.
struct ThreePerRow {
  std::int64_t a = 0, b = 0, c = 0;
  static constexpr int words = 3;
};
struct ToRows {
  std::uint64_t rows, run;  ///< items of a run in a row go to one of `rows`
  using Sum = ThreePerRow;
  MELTSIM_HD std::uint32_t operator()(std::uint64_t i, Sum& s) const {
    if (i % 5 == 3) return 0xffffffffu;
    s = {1, static_cast<std::int64_t>(i) - 1000, -(static_cast<std::int64_t>(i) << 40)};
    return static_cast<std::uint32_t>(i / run % rows);
  }
};

/// Says that it ran, after the result was there.
struct NoteSum {
  const Sum* sum;
  std::uint64_t* noted;
  MELTSIM_HD void operator()(const Sum& given) const { *noted = sum->n + given.n + 1; }
};

/// The oracle's: one thread. Annotated because the body that calls it is.
struct PlainAdder {
  MELTSIM_HD void operator()(std::int64_t* address, std::int64_t value) const { *address += value; }
};

// --- the suite ---------------------------------------------------------------------------------------------

template <class E>
class Verbs : public ::testing::Test {
 protected:
  static std::vector<std::uint32_t> random(std::uint64_t n, std::uint32_t most) {
    std::mt19937 engine(static_cast<std::uint32_t>(n) + most);
    std::vector<std::uint32_t> v(static_cast<std::size_t>(n));
    for (std::uint32_t& x : v) x = engine() % (most + 1u);
    return v;
  }
  static void expect_no_fault(E& ex) { EXPECT_EQ(ex.fault(), std::string{}); }
};

TYPED_TEST_SUITE_P(Verbs);

// GTEST_SKIP and FAIL leave only the function they stand in, so this is no helper function.
#define VERBS_MAKE(ex)                                                       \
  if (!Maker<TypeParam>::missing().empty()) {                                \
    if (Maker<TypeParam>::required()) FAIL() << Maker<TypeParam>::missing(); \
    GTEST_SKIP() << Maker<TypeParam>::missing();                             \
  }                                                                          \
  TypeParam ex = Maker<TypeParam>::make();                                   \
  ASSERT_TRUE(ex.reserve(sizes().back()))

TYPED_TEST_P(Verbs, ForEachVisitsEveryIndexOnce) {
  VERBS_MAKE(ex);
  for (const std::uint64_t n : sizes()) {
    Buffer<TypeParam, std::uint32_t> visits(ex, n + 1, 7u);
    ex.for_each(n, CountVisits{visits.get()});
    const auto got = visits.host();
    for (std::uint64_t i = 0; i < n; ++i) ASSERT_EQ(got[i], 7u + i + 1u) << "n " << n << ", i " << i;
    EXPECT_EQ(got[n], 7u) << "n " << n << ": wrote past the end";
  }
  this->expect_no_fault(ex);
}

// A million items are more than one round of what few threads of every multiprocessor do.
TYPED_TEST_P(Verbs, ForEachStepsAsideAndVisitsEveryIndexOnce) {
  VERBS_MAKE(ex);
  for (const unsigned blocks : {0u, 3u, 1u, 0u}) {
    if constexpr (meltsim::core::runs_tracks<TypeParam>) ex.step_aside(blocks);
    for (const std::uint64_t n : sizes()) {
      Buffer<TypeParam, std::uint32_t> visits(ex, n + 1, 7u);
      ex.for_each(n, CountVisitsModestly{{visits.get()}});
      const auto got = visits.host();
      for (std::uint64_t i = 0; i < n; ++i) ASSERT_EQ(got[i], 7u + i + 1u) << "n " << n << ", i " << i;
      EXPECT_EQ(got[n], 7u) << "n " << n << ": wrote past the end";
    }
  }
  this->expect_no_fault(ex);
}

TYPED_TEST_P(Verbs, ReduceEqualsStdAccumulate) {
  VERBS_MAKE(ex);
  for (const std::uint64_t n : sizes()) {
    const auto host = this->random(n, 0xffffffffu - 1u);
    Buffer<TypeParam, std::uint32_t> values(ex, host);
    Buffer<TypeParam, Sum> out(ex, 1, Sum{99});
    ex.reduce(n, SumOf{values.get()}, out.get());
    EXPECT_EQ(out.host()[0].n, std::accumulate(host.begin(), host.end(), std::uint64_t{0})) << "n " << n;
  }
  this->expect_no_fault(ex);
}

struct NoteSpeed {
  double* noted;
  MELTSIM_HD void operator()(const CheckResult& all) const { *noted = all.max_speed; }
};

TYPED_TEST_P(Verbs, ReduceFindsTheWorstOfWhatWrites) {
  VERBS_MAKE(ex);
  for (const std::uint64_t n : sizes()) {
    const auto host = this->random(n, 1000000u);
    CheckResult expected;
    for (std::uint64_t i = 0; i < n; ++i) expected = CheckResult::combine(expected, Worst{host.data()}.of(i));
    Buffer<TypeParam, std::uint32_t> values(ex, host), written(ex, n, 7u), counted(ex, 50, 3u);
    Buffer<TypeParam, CheckResult> out(ex, 1);
    Buffer<TypeParam, double> noted(ex, 1, -1.0);
    ex.reduce(n, Worst{values.get(), written.get(), counted.get()}, out.get(), NoteSpeed{noted.get()});
    std::vector<std::uint32_t> counts(50, 3u);
    for (const std::uint32_t x : host) ++counts[x % 50u];
    EXPECT_EQ(counted.host(), counts) << "n " << n;
    const CheckResult got = out.host()[0];
    EXPECT_EQ(got.max_speed, expected.max_speed) << "n " << n;
    EXPECT_EQ(got.removed, expected.removed) << "n " << n;
    EXPECT_EQ(got.dense, n) << "n " << n;
    EXPECT_EQ(got.excess, expected.excess) << "n " << n;
    EXPECT_EQ(got.bad, expected.bad) << "n " << n;
    EXPECT_EQ(got.bad_id, expected.bad_id) << "n " << n;
    EXPECT_EQ(got.bad_value, expected.bad_value) << "n " << n;
    EXPECT_EQ(noted.host()[0], expected.max_speed) << "n " << n;
    const auto now = written.host();
    for (std::uint64_t i = 0; i < n; ++i) ASSERT_EQ(now[i], host[i] + 7u) << "n " << n << ", i " << i;
  }
  this->expect_no_fault(ex);
}

template <bool Shared, class E>
void gather_and_reduce(E& ex, const std::vector<std::uint32_t>& host, bool some_bad) {
  const std::uint64_t n = host.size();
  Buffer<E, std::uint32_t> values(ex, host), written(ex, n, 7u), counted(ex, 50, 0u);
  Buffer<E, CheckResult> out(ex, 1);
  Buffer<E, double> noted(ex, 1, -1.0);
  const GatherWorst<Shared> body{values.get(), written.get(), counted.get(), some_bad};
  CheckResult expected;
  for (std::uint64_t i = 0; i < n; ++i)
    expected = CheckResult::combine(expected, body.of(i, host[i]).result());
  for (const std::uint32_t times : {1u, 2u}) {  // what was handed in does not come again
    ex.gather_reduce(n, body, out.get(), NoteSpeed{noted.get()});
    const CheckResult got = out.host()[0];
    EXPECT_EQ(got.bad, expected.bad) << "n " << n;
    EXPECT_EQ(got.bad_value, expected.bad_value) << "n " << n;
    if (expected.bad != 0u) {
      EXPECT_EQ(got.bad_id, expected.bad_id) << "n " << n;
    } else {  // where something is, nobody asks for these
      EXPECT_EQ(got.max_speed, expected.max_speed) << "n " << n;
      EXPECT_EQ(got.max_density, expected.max_density) << "n " << n;
      EXPECT_EQ(got.excess, expected.excess) << "n " << n;
      EXPECT_EQ(got.dense, expected.dense) << "n " << n;
      EXPECT_EQ(got.removed, expected.removed) << "n " << n;
      EXPECT_EQ(noted.host()[0], expected.max_speed) << "n " << n;
    }
    const auto now = written.host();
    for (std::uint64_t i = 0; i < n; ++i)
      ASSERT_EQ(now[i], 7u + times * (host[i] + 420u)) << "n " << n << ", i " << i;
    const auto counts = counted.host();
    EXPECT_EQ(std::accumulate(counts.begin(), counts.end(), std::uint64_t{0}), times * n);
  }
}

TYPED_TEST_P(Verbs, GatherReduceAddsPartsAndFindsTheWorst) {
  VERBS_MAKE(ex);
  for (const std::uint64_t n : sizes()) {
    const auto host = this->random(n, 1000000u);
    for (const bool some_bad : {false, true}) {
      gather_and_reduce<true>(ex, host, some_bad);
      gather_and_reduce<false>(ex, host, some_bad);
    }
  }
  this->expect_no_fault(ex);
}

TYPED_TEST_P(Verbs, ReduceOfRealsRepeatsBitForBit) {
  VERBS_MAKE(ex);
  const std::uint64_t n = sizes().back();
  Buffer<TypeParam, std::uint32_t> values(ex, this->random(n, 1000000u));
  Buffer<TypeParam, RealSum> first(ex, 1), again(ex, 1);
  ex.reduce(n, InverseOf{values.get()}, first.get());
  for (int k = 0; k < 5; ++k) {
    ex.reduce(n, InverseOf{values.get()}, again.get());
    EXPECT_EQ(again.host()[0].x, first.host()[0].x);
  }
  this->expect_no_fault(ex);
}

TYPED_TEST_P(Verbs, ScanEqualsStdPartialSum) {
  VERBS_MAKE(ex);
  for (const std::uint64_t n : sizes()) {
    const auto host = this->random(n, 3u);
    std::vector<std::uint32_t> expected(host.size());
    std::partial_sum(host.begin(), host.end(), expected.begin());
    Buffer<TypeParam, std::uint32_t> values(ex, host), out(ex, n, 99u);
    ex.scan(n, Values{values.get()}, out.get());
    EXPECT_EQ(out.host(), expected) << "n " << n;
    ex.scan(n, Values{values.get()}, values.get());
    EXPECT_EQ(values.host(), expected) << "in its own place, n " << n;
  }
  this->expect_no_fault(ex);
}

// Two running counts in one word: neither reaches into the other.
TYPED_TEST_P(Verbs, ScanOfWordsKeepsTheirHalvesApart) {
  VERBS_MAKE(ex);
  for (const std::uint64_t n : sizes()) {
    const auto host = this->random(n, 3u);
    std::vector<std::uint64_t> expected(host.size());
    std::uint64_t high = 0, low = 0;
    for (std::size_t i = 0; i < host.size(); ++i)
      expected[i] = (high += host[i]) << 32 | (low += host[i] ^ 1u);
    Buffer<TypeParam, std::uint32_t> values(ex, host);
    Buffer<TypeParam, std::uint64_t> out(ex, n, 99u);
    ex.scan(n, InBothHalves{values.get()}, out.get());
    EXPECT_EQ(out.host(), expected) << "n " << n;
  }
  this->expect_no_fault(ex);
}

// 14 bits: a small bounded domain, and an even number of 8-bit passes. 20: an odd one. 64: an unbounded
// domain.
TYPED_TEST_P(Verbs, SortEqualsStdStableSort) {
  VERBS_MAKE(ex);
  for (const std::uint32_t bits : {2u, 14u, 20u, 33u, 64u}) {
    // As in the library: one bit more than cells need, so that the key of a removed particle sorts last.
    const std::uint64_t mask = (std::uint64_t{1} << (bits - 1)) - 1;
    for (const std::uint64_t n : sizes()) {
      std::mt19937_64 engine(n + bits);
      std::vector<std::pair<std::uint64_t, std::uint32_t>> expected;
      std::vector<std::uint64_t> keys;
      std::vector<std::uint32_t> values;
      for (std::uint64_t i = 0; i < n; ++i) {
        // Many equal keys, so that stability shows; now and then that of a removed particle, all bits set.
        const std::uint64_t spread = bits == 64 ? engine() : engine() % (n / 3 + 1);
        keys.push_back(i % 11 == 5 ? ~std::uint64_t{0}
                                   : (i % 2 == 0 ? spread & mask : (i * 7919) % 50 & mask));
        values.push_back(static_cast<std::uint32_t>(i));
        expected.emplace_back(keys.back(), values.back());
      }
      std::stable_sort(expected.begin(), expected.end(),
                       [](const auto& a, const auto& b) { return a.first < b.first; });
      Buffer<TypeParam, std::uint64_t> k(ex, keys), ko(ex, n);
      Buffer<TypeParam, std::uint32_t> v(ex, values), vo(ex, n);
      ex.sort(n, bits, k.get(), v.get(), ko.get(), vo.get());
      const auto got_keys = ko.host();
      const auto got_values = vo.host();
      for (std::uint64_t i = 0; i < n; ++i) {
        ASSERT_EQ(got_keys[i], expected[i].first) << "n " << n << ", bits " << bits << ", i " << i;
        ASSERT_EQ(got_values[i], expected[i].second) << "n " << n << ", bits " << bits << ", i " << i;
      }
    }
  }
  this->expect_no_fault(ex);
}

TYPED_TEST_P(Verbs, AccumulateIsExact) {
  VERBS_MAKE(ex);
  for (const std::uint32_t bins : {1u, 7u, 64u})
    for (const std::uint64_t n : sizes()) {
      std::vector<std::int64_t> expected(bins, -5);
      for (std::uint64_t i = 0; i < n; ++i) AddToBins{expected.data(), bins}(i, PlainAdder{});
      Buffer<TypeParam, std::int64_t> sums(ex, bins, std::int64_t{-5});
      ex.accumulate(n, AddToBins{sums.get(), bins});
      EXPECT_EQ(sums.host(), expected) << "n " << n << ", bins " << bins;
    }
  this->expect_no_fault(ex);
}

TYPED_TEST_P(Verbs, GatherListedVisitsWhatIsWantedOnce) {
  VERBS_MAKE(ex);
  for (const std::uint64_t n : sizes()) {
    const auto host = this->random(n, 1000u);
    Buffer<TypeParam, std::uint32_t> values(ex, host), list(ex, n + 1, 99u);
    Buffer<TypeParam, std::uint64_t> out(ex, n, std::uint64_t{5});
    const PartsOfSome body{values.get(), out.get()};
    for (int round = 0; round < 2; ++round) {  // a list made anew forgets the one before
      ex.select(n, body, list.get());
      ex.gather_listed(n, list.get(), body);
    }
    const auto got = out.host();
    for (std::uint64_t i = 0; i < n; ++i) {
      std::uint64_t sum = host[i] % 7u;
      for (std::uint64_t k = 1; k < 9; ++k) sum = 10 * sum + host[i] % 7u + k;
      const bool wanted = PartsOfSome{host.data(), nullptr}.wanted(i);
      ASSERT_EQ(got[i], wanted ? 5 + 2 * sum : 5u) << "n " << n << ", i " << i;
    }
  }
  this->expect_no_fault(ex);
}

// One bucket, few (all but empty ones between them), and more buckets than items; any order within one.
TYPED_TEST_P(Verbs, BucketEqualsStdSort) {
  VERBS_MAKE(ex);
  for (const std::uint32_t m : {1u, 2u, 50u, 100000u, 1000003u})
    for (const std::uint64_t n : sizes()) {
      if (n == 0) continue;
      auto host = this->random(n, m - 1);
      if (n > 1000 && m == 50)
        for (std::uint64_t i = 0; i < n; ++i) host[i] = i % 20000 == 0 ? host[i] : m - 1;
      std::vector<std::uint32_t> expected(n);
      std::iota(expected.begin(), expected.end(), 0u);
      std::stable_sort(expected.begin(), expected.end(),
                       [&](std::uint32_t a, std::uint32_t b) { return host[a] < host[b]; });
      Buffer<TypeParam, std::uint32_t> values(ex, host), bucket_of(ex, n), begin(ex, m + 1, 99u),
          order(ex, n), counts(ex, TypeParam::count_room(m) + 1, 0u);
      // Under a guard it may forget where buckets begin, and after that knows again.
      Buffer<TypeParam, std::uint32_t> guard(ex, 1, 0u);
      ex.set_guard(guard.get());
      for (const std::uint32_t halted : {0u, 1u, 0u}) {
        ex.upload(guard.get(), &halted, sizeof halted);
        ex.bucket(n, m, BucketOf{values.get()}, bucket_of.get(), begin.get(), order.get(), counts.get());
      }
      ex.set_guard(nullptr);
      Buffer<TypeParam, std::uint64_t> noted(ex, 1);
      for (int again = 0; again < 2; ++again) {  // in two: each time finds what the one before left
        ex.accumulate(n, CountInto{values.get(), counts.get()});
        ex.begin_buckets(m, counts.get(), begin.get(), NoteRun{noted.get()});
        ex.fill_buckets(n, bucket_of.get(), begin.get(), order.get(), counts.get());
      }
      EXPECT_EQ(noted.host()[0], 2u);
      EXPECT_EQ(bucket_of.host(), host);
      auto got = order.host();
      const auto first = begin.host();
      EXPECT_EQ(first[m], n);
      ASSERT_TRUE(std::is_sorted(first.begin(), first.end()));
      for (std::uint32_t b = 0; b < m; ++b) std::sort(got.begin() + first[b], got.begin() + first[b + 1]);
      EXPECT_EQ(got, expected) << "n " << n << ", buckets " << m;
      for (std::uint32_t b = 0; b < m; ++b) {
        const auto at = std::lower_bound(expected.begin(), expected.end(), b,
                                         [&](std::uint32_t i, std::uint32_t v) { return host[i] < v; });
        ASSERT_EQ(first[b], static_cast<std::uint32_t>(at - expected.begin())) << "bucket " << b;
      }
    }
  this->expect_no_fault(ex);
}

TYPED_TEST_P(Verbs, GatherAddsPartsInOrder) {
  VERBS_MAKE(ex);
  for (const std::uint64_t n : sizes()) {
    const auto host = this->random(n, 100u);
    const std::uint32_t parts = meltsim::core::gather_parts<PartsOf>(n);
    Buffer<TypeParam, std::uint32_t> values(ex, host);
    Buffer<TypeParam, std::uint64_t> out(ex, n + 1, std::uint64_t{7});
    ex.gather(n, PartsOf{values.get(), out.get()});
    const auto got = out.host();
    for (std::uint64_t i = 0; i < n; ++i)
      ASSERT_EQ(got[i], parts == 3 ? 111u * host[i] + 12u : host[i]) << "n " << n << ", i " << i;
    EXPECT_EQ(got[n], 7u);
  }
  this->expect_no_fault(ex);
}

TYPED_TEST_P(Verbs, GatherJoinsWhatPartsStored) {
  VERBS_MAKE(ex);
  for (const std::uint64_t n : sizes()) {
    const auto host = this->random(n, 100u);
    const std::uint32_t parts = meltsim::core::gather_parts<PartsThatJoin>(n);
    Buffer<TypeParam, std::uint32_t> values(ex, host), stored(ex, 3 * n + 1, 0u), joined(ex, n + 1, 0u);
    Buffer<TypeParam, std::uint64_t> out(ex, n + 1, std::uint64_t{7});
    ex.gather(n, PartsThatJoin{values.get(), stored.get(), joined.get(), out.get()});
    const auto got = out.host();
    for (std::uint64_t i = 0; i < n; ++i) {
      const std::uint64_t v = host[i], all = parts == 3 ? 3 * v + 3 : v;
      ASSERT_EQ(got[i],
                7 + (parts == 3 ? 100 * (v + all) + 10 * (v + 1 + 2 * all) + v + 2 + 3 * all : v + all))
          << "n " << n << ", i " << i;
    }
    EXPECT_EQ(got[n], 7u);
  }
  this->expect_no_fault(ex);
}

// Runs: one row for all, a change within a warp, within a thread's items, for every item.
TYPED_TEST_P(Verbs, SumByRowIsExact) {
  VERBS_MAKE(ex);
  for (const std::uint64_t run :
       {std::uint64_t{1} << 30, std::uint64_t{1000}, std::uint64_t{45}, std::uint64_t{1}})
    for (const std::uint64_t n : sizes()) {
      std::vector<ThreePerRow> expected(7, ThreePerRow{1, 2, 3});
      for (std::uint64_t i = 0; i < n; ++i) {
        ThreePerRow s;
        const std::uint32_t row = ToRows{7, run}(i, s);
        if (row == 0xffffffffu) continue;
        expected[row].a += s.a;
        expected[row].b += s.b;
        expected[row].c += s.c;
      }
      Buffer<TypeParam, ThreePerRow> rows(ex, 7, ThreePerRow{1, 2, 3});
      ex.sum_by_row(n, ToRows{7, run}, rows.get());
      const auto got = rows.host();
      for (int r = 0; r < 7; ++r) {
        EXPECT_EQ(got[r].a, expected[r].a) << "n " << n << ", run " << run << ", row " << r;
        EXPECT_EQ(got[r].b, expected[r].b) << "n " << n << ", run " << run << ", row " << r;
        EXPECT_EQ(got[r].c, expected[r].c) << "n " << n << ", run " << run << ", row " << r;
      }
    }
  this->expect_no_fault(ex);
}

TYPED_TEST_P(Verbs, ReduceTellsWhoComesLast) {
  VERBS_MAKE(ex);
  for (const std::uint64_t n : sizes()) {
    Buffer<TypeParam, std::uint32_t> values(ex, n, 2u);
    Buffer<TypeParam, Sum> out(ex, 1, Sum{99});
    Buffer<TypeParam, std::uint64_t> noted(ex, 1);
    for (int k = 0; k < 2; ++k)  // twice: nothing is left behind
      ex.reduce(n, SumOf{values.get()}, out.get(), NoteSum{out.get(), noted.get()});
    EXPECT_EQ(noted.host()[0], 4 * n + 1) << "n " << n;
  }
  this->expect_no_fault(ex);
}

// The same key stands for the same launches: what is recorded runs again without being asked.
TYPED_TEST_P(Verbs, RepeatRunsTheSameAgain) {
  VERBS_MAKE(ex);
  const std::uint64_t n = 1000;
  Buffer<TypeParam, std::uint32_t> a(ex, n, 0u), b(ex, n, 0u);
  const auto once = [&](std::uint64_t key, std::uint32_t* to) {
    ex.repeat({key}, [&] { ex.for_each(n, CountVisits{to}); });
  };
  for (int k = 0; k < 5; ++k) once(1, a.get());
  for (std::uint64_t k = 0; k < 40; ++k) once(100 + k, b.get());  // more than are kept
  once(1, a.get());
  std::vector<std::uint32_t> expected(n);
  for (std::uint64_t i = 0; i < n; ++i) expected[i] = 6u * (static_cast<std::uint32_t>(i) + 1u);
  EXPECT_EQ(a.host(), expected);
  ex.forget_repeats();
  EXPECT_EQ(ex.captures(), 0u);
  once(1, a.get());
  once(1, a.get());
  EXPECT_LE(ex.captures(), 1u);
  this->expect_no_fault(ex);
}

// What repeats behind a first launch whose arguments change: every time sees those of its own time.
TYPED_TEST_P(Verbs, RepeatTakesItsFirstLaunchAnew) {
  VERBS_MAKE(ex);
  Buffer<TypeParam, std::uint32_t> value(ex, 1, 0u), seen(ex, 12, 0u);
  std::vector<std::uint32_t> expected;
  for (std::uint32_t k = 0; k < 12; ++k) {
    expected.push_back(100u + k);
    ex.repeat(
        {k % 3u}, [&] { ex.fill(1, 100u + k, value.get()); },
        [&] { ex.copy(1, value.get(), seen.get() + k % 3u); });
    if (k >= 3) ex.copy(1, seen.get() + k % 3u, seen.get() + k);
  }
  const std::vector<std::uint32_t> got = seen.host();
  for (std::size_t k = 3; k < 12; ++k) EXPECT_EQ(got[k], expected[k]) << k;
  EXPECT_LE(ex.captures(), 3u);
  this->expect_no_fault(ex);
}

TYPED_TEST_P(Verbs, CopyAndFillTouchOnlyTheirRange) {
  VERBS_MAKE(ex);
  for (const std::uint64_t n : sizes()) {
    const auto host = this->random(n + 1, 1000u);
    Buffer<TypeParam, std::uint32_t> from(ex, host), to(ex, n + 1, 7u);
    ex.copy(n, from.get(), to.get());
    auto expected = host;
    expected[n] = 7u;
    EXPECT_EQ(to.host(), expected) << "n " << n;
    ex.fill(n, 5u, to.get());
    std::fill_n(expected.begin(), n, 5u);
    EXPECT_EQ(to.host(), expected) << "n " << n;
    ex.zero(to.get(), n * sizeof(std::uint32_t));
    std::fill_n(expected.begin(), n, 0u);
    EXPECT_EQ(to.host(), expected) << "n " << n;
  }
  this->expect_no_fault(ex);
}

TYPED_TEST_P(Verbs, GuardStopsWhatWritesState) {
  VERBS_MAKE(ex);
  const std::uint64_t n = 1000;
  Buffer<TypeParam, std::uint32_t> guard(ex, 1, 0u), values(ex, n, 3u), other(ex, n, 4u);
  Buffer<TypeParam, Sum> sum(ex, 1, Sum{99});
  Buffer<TypeParam, std::int64_t> bins(ex, 1, std::int64_t{-5});
  ex.set_guard(guard.get());
  ex.fill(n, 1u, values.get());
  EXPECT_EQ(values.host(), std::vector<std::uint32_t>(n, 1u)) << "a guard of zero lets verbs run";
  const std::uint32_t halted = 2;
  ex.upload(guard.get(), &halted, sizeof halted);
  ex.fill(n, 9u, values.get());
  ex.copy(n, other.get(), values.get());
  ex.for_each(n, CountVisits{values.get()});
  ex.reduce(n, SumOf{values.get()}, sum.get());
  ex.accumulate(n, AddToBins{bins.get(), 1});
  Buffer<TypeParam, CheckResult> worst(ex, 1);
  Buffer<TypeParam, double> noted(ex, 1, -1.0);
  Buffer<TypeParam, std::uint32_t> counted(ex, 50, 0u);
  ex.gather_reduce(n, GatherWorst<true>{other.get(), values.get(), counted.get(), false}, worst.get(),
                   NoteSpeed{noted.get()});
  EXPECT_EQ(noted.host()[0], -1.0);
  EXPECT_EQ(counted.host(), std::vector<std::uint32_t>(50, 0u));
  EXPECT_EQ(values.host(), std::vector<std::uint32_t>(n, 1u));
  EXPECT_EQ(sum.host()[0].n, 99u);
  EXPECT_EQ(bins.host()[0], -5);
  ex.scan(n, Values{values.get()}, other.get());  // working space: may do anything but fail
  ex.synchronize();
  this->expect_no_fault(ex);
}

// Whoever lowers a number learns what it was, so that nobody is lost who hung from it: among those that lowered
// one, every value but the least is what another found there, once.
TYPED_TEST_P(Verbs, LoweringTellsWhatWasThere) {
  VERBS_MAKE(ex);
  const std::uint32_t n = 5000, bins = 7, none = 0xffffffffu;
  Buffer<TypeParam, std::uint32_t> least(ex, bins, none), was(ex, n, 0u);
  ex.accumulate(n, LowerTo{least.get(), was.get(), bins});
  const auto low = least.host(), found = was.host();
  for (std::uint32_t b = 0; b < bins; ++b) {
    EXPECT_EQ(low[b], 7u * b + 3u);
    std::vector<std::uint32_t> replaced, placed{none};
    for (std::uint32_t i = b; i < n; i += bins)
      if (7u * i + 3u < found[i]) {
        replaced.push_back(found[i]);
        if (7u * i + 3u != low[b]) placed.push_back(7u * i + 3u);
      }
    std::sort(replaced.begin(), replaced.end());
    std::sort(placed.begin(), placed.end());
    EXPECT_EQ(replaced, placed) << b;
  }
  this->expect_no_fault(ex);
}

TYPED_TEST_P(Verbs, TimingsAreReadAfterSynchronize) {
  VERBS_MAKE(ex);
  const std::uint64_t n = sizes().back();
  Buffer<TypeParam, std::uint32_t> values(ex, n);
  EXPECT_EQ(ex.collect().median(3), 0.0);
  for (int k = 0; k < 100; ++k) {  // more than any ring holds
    ex.begin_stage(3, "test.stage");
    ex.for_each(n, CountVisits{values.get()});
    ex.end_stage(3);
  }
  ex.synchronize();
  EXPECT_GT(ex.collect().median(3), 0.0);
  EXPECT_LT(ex.collect().median(3), 1000.0);
  EXPECT_EQ(ex.collect().median(2), 0.0);
  this->expect_no_fault(ex);
}

REGISTER_TYPED_TEST_SUITE_P(Verbs, ForEachStepsAsideAndVisitsEveryIndexOnce, BucketEqualsStdSort,
                            GatherAddsPartsInOrder, GatherJoinsWhatPartsStored, SumByRowIsExact,
                            ReduceTellsWhoComesLast, RepeatRunsTheSameAgain, RepeatTakesItsFirstLaunchAnew,
                            ForEachVisitsEveryIndexOnce, ReduceEqualsStdAccumulate,
                            ReduceFindsTheWorstOfWhatWrites, GatherReduceAddsPartsAndFindsTheWorst,
                            ReduceOfRealsRepeatsBitForBit, ScanEqualsStdPartialSum,
                            ScanOfWordsKeepsTheirHalvesApart, SortEqualsStdStableSort, AccumulateIsExact,
                            GatherListedVisitsWhatIsWantedOnce, CopyAndFillTouchOnlyTheirRange,
                            GuardStopsWhatWritesState, LoweringTellsWhatWasThere,
                            TimingsAreReadAfterSynchronize);

}  // namespace verbs_test
