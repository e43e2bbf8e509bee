puts "the end"
