// SPDX-License-Identifier: Apache-2.0
// The verbs on CUDA: the text of tests/verbs, and what only CUDA promises.
#include "exec/exec_cuda_bucket.cuh"
#include "exec/exec_cuda_scan.cuh"
#include "support/require_gpu.hpp"
#include "verbs/verbs_test.hpp"

namespace verbs_test {

using meltsim::core::CudaExec;

template <>
struct Maker<CudaExec> {
  static std::string missing() { return meltsim_test::why_no_gpu(); }
  static bool required() { return meltsim_test::gpu_required(); }
  static CudaExec make() { return CudaExec(0, nullptr); }
};

INSTANTIATE_TYPED_TEST_SUITE_P(Cuda, Verbs, CudaExec);

/// Two at once, but for one of ten, which is left over. More to add to none in long runs, to all in others, to some
/// elsewhere.
struct TwoAtOnce {
  static constexpr std::uint32_t resident_warps_of_two = 32;
  std::uint64_t n;
  const std::uint32_t* values;
  std::uint64_t* out;
  struct Sum {
    std::uint64_t n = 0;
  };
  MELTSIM_HD std::uint32_t two(std::uint64_t i, bool alone, Sum (&s)[2]) const {
    s[0].n = values[i];
    if (alone || i + 1 >= n || (i + 1) % 10u == 7u) return 1;
    s[1].n = values[i + 1];
    return 2;
  }
  MELTSIM_HD std::uint64_t left_over(std::uint64_t k) const { return 10 * k + 7; }
  MELTSIM_HD bool unfinished(std::uint64_t i) const {
    return i / 500u % 3u == 0u || (i / 500u % 3u == 1u && values[i] % 3u == 0u);
  }
  MELTSIM_HD void more(std::uint64_t i, std::uint32_t, std::uint32_t, Sum& s) const { s.n += 1000 * (i + 1); }
  MELTSIM_HD void finish(std::uint64_t i, const Sum& s) const { out[i] += s.n; }
};

TEST(CudaVerbs, GatherTwoFinishesEveryoneOnce) {
  MELTSIM_NEEDS_GPU();
  CudaExec ex(0, nullptr);
  for (const std::uint64_t n : sizes()) {
    std::vector<std::uint32_t> host;
    for (std::uint64_t i = 0; i < n; ++i)
      host.push_back(static_cast<std::uint32_t>(i * 2654435761u >> 7) % 100u);
    Buffer<CudaExec, std::uint32_t> values(ex, host);
    Buffer<CudaExec, std::uint64_t> out(ex, n + 1, std::uint64_t{7});
    ex.gather_two(n, (n + 9) / 10, TwoAtOnce{n, values.get(), out.get()});
    const auto got = out.host();
    const TwoAtOnce same{n, host.data(), nullptr};
    for (std::uint64_t i = 0; i < n; ++i)
      ASSERT_EQ(got[i], 7 + host[i] + (same.unfinished(i) ? 1000 * (i + 1) : 0)) << "n " << n << ", i " << i;
    EXPECT_EQ(got[n], 7u);
  }
  EXPECT_EQ(ex.fault(), "");
}

// A hidden wait, allocation or read-back would fail the capture.
TEST(CudaVerbs, CanBeCapturedAndReplayed) {
  MELTSIM_NEEDS_GPU();
  cudaStream_t stream = nullptr;
  ASSERT_EQ(cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking), cudaSuccess);
  {
    CudaExec ex(0, stream);
    const std::uint64_t n = 100003;
    ASSERT_TRUE(ex.reserve(n));
    std::vector<std::uint64_t> host_keys;
    std::vector<std::uint32_t> host_values;
    for (std::uint64_t i = 0; i < n; ++i) {
      host_keys.push_back((n - i) * 2654435761u % (1u << 20));
      host_values.push_back(static_cast<std::uint32_t>(i));
    }
    Buffer<CudaExec, std::uint64_t> keys(ex, host_keys), keys_in(ex, n), keys_out(ex, n);
    Buffer<CudaExec, std::uint32_t> values(ex, host_values), values_in(ex, n), values_out(ex, n), sums(ex, n);
    Buffer<CudaExec, Sum> total(ex, 1);
    Buffer<CudaExec, std::int64_t> bins(ex, 1);
    ex.synchronize();
    const auto enqueue = [&] {
      ex.begin_stage(0, "test.capture");
      ex.copy(n, keys.get(), keys_in.get());
      ex.copy(n, values.get(), values_in.get());
      ex.sort(n, 20, keys_in.get(), values_in.get(), keys_out.get(), values_out.get());
      ex.scan(n, Values{values_out.get()}, sums.get());
      ex.reduce(n, SumOf{sums.get()}, total.get());
      ex.fill(1, std::int64_t{0}, bins.get());
      ex.accumulate(n, AddToBins{bins.get(), 1});
      ex.end_stage(0);
    };
    enqueue();
    const auto expected_sums = sums.host();
    const auto expected_total = total.host()[0].n;
    const auto expected_bin = bins.host()[0];
    ex.fill(n, 0u, sums.get());
    ex.synchronize();

    cudaGraph_t graph = nullptr;
    cudaGraphExec_t replay = nullptr;
    ASSERT_EQ(cudaStreamBeginCapture(stream, cudaStreamCaptureModeGlobal), cudaSuccess);
    enqueue();
    ASSERT_EQ(cudaStreamEndCapture(stream, &graph), cudaSuccess);
    EXPECT_EQ(ex.fault(), "");
    ASSERT_EQ(cudaGraphInstantiate(&replay, graph, 0), cudaSuccess);
    for (int k = 0; k < 2; ++k) {
      ASSERT_EQ(cudaGraphLaunch(replay, stream), cudaSuccess);
      EXPECT_EQ(sums.host(), expected_sums);
      EXPECT_EQ(total.host()[0].n, expected_total);
      EXPECT_EQ(bins.host()[0], expected_bin);
    }
    EXPECT_EQ(cudaGraphExecDestroy(replay), cudaSuccess);
    EXPECT_EQ(cudaGraphDestroy(graph), cudaSuccess);
  }
  EXPECT_EQ(cudaStreamDestroy(stream), cudaSuccess);
}

TEST(CudaVerbs, MovedExecutorGoesOnWorking) {
  MELTSIM_NEEDS_GPU();
  CudaExec first(0, nullptr);
  ASSERT_TRUE(first.reserve(1000));
  CudaExec second(std::move(first));
  Buffer<CudaExec, std::uint32_t> values(second, 1000, 3u);
  Buffer<CudaExec, Sum> out(second, 1);
  second.reduce(1000, SumOf{values.get()}, out.get());
  EXPECT_EQ(out.host()[0].n, 3000u);
  EXPECT_EQ(second.fault(), "");
}

TEST(CudaVerbs, ErrorsAreKeptAndReportedOnce) {
  MELTSIM_NEEDS_GPU();
  CudaExec ex(0, nullptr);
  ASSERT_TRUE(ex.reserve(1000));
  Buffer<CudaExec, std::uint64_t> k(ex, 100), ko(ex, 100);
  Buffer<CudaExec, std::uint32_t> v(ex, 100), vo(ex, 100);
  ex.sort(std::uint64_t{1} << 31, 64, k.get(), v.get(), ko.get(),
          vo.get());  // far more than reserved: refused
  EXPECT_NE(ex.fault().find("more items than were reserved"), std::string::npos);
  EXPECT_EQ(ex.fault(), "");
  EXPECT_EQ(cudaGetLastError(), cudaSuccess) << "the host must not find our errors";
  EXPECT_EQ(ex.allocate(std::uint64_t{1} << 60), nullptr);
  EXPECT_EQ(ex.fault(), "") << "running out of memory is an answer, not a fault";
}

TEST(CudaVerbs, ReducingMoreThanWasReservedIsAFault) {
  MELTSIM_NEEDS_GPU();
  CudaExec ex(0, nullptr);
  ASSERT_TRUE(ex.reserve(1000));
  Buffer<CudaExec, std::uint32_t> values(ex, 10000, 2u);
  Buffer<CudaExec, Sum> out(ex, 1, Sum{99});
  ex.reduce(1000, SumOf{values.get()}, out.get());
  EXPECT_EQ(out.host()[0].n, 2000u);
  ex.reduce(10000, SumOf{values.get()}, out.get());
  EXPECT_EQ(out.host()[0].n, 2000u) << "as it was";
  EXPECT_NE(ex.fault().find("more items than were reserved"), std::string::npos);
  ASSERT_TRUE(ex.reserve(10000));
  ex.reduce(10000, SumOf{values.get()}, out.get());
  EXPECT_EQ(out.host()[0].n, 20000u);
  EXPECT_EQ(ex.fault(), "");
}

TEST(CudaVerbs, WorkingSpaceGrowsAndIsGivenBack) {
  MELTSIM_NEEDS_GPU();
  CudaExec ex(0, nullptr);
  ASSERT_TRUE(ex.reserve(10000000));
  const std::uint64_t large = ex.reserved_bytes();
  EXPECT_LT(large, 10000000 * std::uint64_t{2}) << "working space should stay a small part of the channels";
  ASSERT_TRUE(ex.reserve(1000));
  EXPECT_LT(ex.reserved_bytes(), large);
}

}  // namespace verbs_test
