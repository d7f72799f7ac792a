"""Files: rosbag2 folders of MCAP files, written, scanned, read and repaired."""
