// A step in the steady state takes no heap memory, as counted in malloc.
#include <cerrno>

#include "slam/filter.h"
#include "tests/slam/synthetic_room.h"

namespace {

bool counting = false;
int asked = 0;  // allocations requested while counting

void* counted(void* memory) {
  if (counting) ++asked;
  return memory;
}

}  // namespace

// glibc's own allocator, under the names that operator new, Eigen and OpenCV call.
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);

void* malloc(std::size_t size) { return counted(__libc_malloc(size)); }
void* calloc(std::size_t count, std::size_t size) { return counted(__libc_calloc(count, size)); }
void* realloc(void* old, std::size_t size) { return counted(__libc_realloc(old, size)); }
void* memalign(std::size_t alignment, std::size_t size) { return counted(__libc_memalign(alignment, size)); }
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  return counted(__libc_memalign(alignment, size));
}
int posix_memalign(void** memory, std::size_t alignment, std::size_t size) {
  *memory = counted(__libc_memalign(alignment, size));
  return *memory == nullptr ? ENOMEM : 0;
}
}

namespace slam {
namespace {

TEST(Allocation, IsCountedForNewEigenAndOpenCV) {
  counting = true;
  ::operator delete(::operator new(40));  // a call that compilers may not remove
  const Eigen::MatrixXd matrix(20, 20);
  EXPECT_EQ(asked, 2);
  const cv::Mat image(20, 20, CV_8UC1);
  EXPECT_GE(asked, 3);
  counting = false;
}

TEST(Allocation, ReasonsReuseTheirMemory) {
  Reasons reasons;
  reasons.add("planned velocity is beyond its gate"), reasons.clear();
  asked = 0, counting = true;
  reasons.add("gyro is silent"), reasons.add("image is flat");
  counting = false;
  EXPECT_EQ(asked, 0) << reasons.text();
  EXPECT_EQ(reasons.text(), "gyro is silent; image is flat");
}

TEST(Allocation, AStepInTheSteadyStateAllocatesNothing) {
  const synthetic::Recording recording = synthetic::recorded(3.5, 0.1);
  Filter filter(Options{}, synthetic::calibration(), recording.walk().X_WC(0), 1);
  int initialized = 0, accepted = 0;
  for (int k = 0; k < recording.walk().frames(); ++k) {
    const Observation o = recording.observation(k);
    counting = k >= 45;  // both feet have been set down; the map has landmarks
    asked = 0;
    const FrameReport& report = filter.step(o);
    counting = false;
    EXPECT_EQ(asked, 0) << "frame " << k << ' ' << report.refused.text();
    if (k < 45) continue;
    initialized += static_cast<int>(report.initialized.size());
    accepted += report.accepted;
  }
  EXPECT_GE(initialized, 1);  // otherwise detection was not tested
  EXPECT_GE(accepted, 300);
}

}  // namespace
}  // namespace slam
