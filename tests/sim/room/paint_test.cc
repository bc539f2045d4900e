#include "sim/room/paint.h"

#include <gtest/gtest.h>

namespace sim::room {

TEST(Paint, DependsOnNameAndSeedOnly) {
  const cv::Mat3b books = paint_texture("books_2", 1);
  paint_texture("poster_1", 1);
  EXPECT_EQ(cv::norm(books, paint_texture("books_2", 1), cv::NORM_INF), 0);
  EXPECT_GT(cv::norm(books, paint_texture("books_2", 2), cv::NORM_INF), 100);
  EXPECT_GT(cv::norm(books, paint_texture("books_3", 1), cv::NORM_INF), 100);
  EXPECT_TRUE(paint_texture("no such thing_1", 1).empty());
}

}  // namespace sim::room
