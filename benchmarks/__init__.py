"""Studies of cost, accuracy and stability: each returns data, writes files and draws charts."""
